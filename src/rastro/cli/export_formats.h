// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "rastro/base/append_file.h"
#include "rastro/base/task_pool.h"
#include "rastro/cli/export_input.h"
#include "rastro/cli/scene_input.h"
#include "rastro/map/cloud/build_cloud.h"
#include "rastro/map/octree/occupancy_octree.h"

namespace rastro::cli {

/// What the flags of `rastro export` ask for.
struct ExportSettings {
  std::string to, out;
  std::string images;    ///< colmap, mcap: the recording of the keyframes; empty: that of the run.
  CloudOptions cloud;    ///< Its submap is that of every format.
  OctreeOptions octree;  ///< For octomap and pgm.
  std::optional<double> voxel_m;
  double max_depth_m = 5.0;                ///< As the sizes of voxels and cells, fitted to the sensor where not given.
  double lowest_m = 0.1, highest_m = 1.8;  ///< pgm: above the floor.
  bool upright = false;
  SceneFlags scene;  ///< html, mcap.
};

/// Facts to print about an export, in order.
using ExportFacts = nlohmann::ordered_json;

struct ExportJob {
  const ExportSettings& settings;
  const ExportInput& input;
  TaskPool& pool;
  MapProgress progress;
};

// Each writes one format (or two alike, by settings.to). Error where the input lacks what it is made from.

ExportFacts export_cloud(const ExportJob& job);  ///< Surfaces of images, else the points of all layers.
ExportFacts export_mesh(const ExportJob& job);   ///< Of images, as the next.
ExportFacts export_octomap(const ExportJob& job);
ExportFacts export_pgm(const ExportJob& job);     ///< Occupancy grid of scans, else a slice of what images show.
ExportFacts export_g2o(const ExportJob& job);     ///< Essential graph of landmarks, else all constraints.
ExportFacts export_colmap(const ExportJob& job);  ///< Of images, else of landmarks.
ExportFacts export_landmark_list(const ExportJob& job);
ExportFacts export_image(const ExportJob& job);
ExportFacts export_poses(const ExportJob& job);
ExportFacts export_depth_images(const ExportJob& job);  ///< Of semi-dense depth.
ExportFacts export_depth_video(const ExportJob& job);   ///< Of semi-dense depth, as the one before.
ExportFacts export_word_images(const ExportJob& job);   ///< Of signatures.
ExportFacts export_html(const ExportJob& job);          ///< Everything there is to see.
ExportFacts export_mcap(const ExportJob& job);          ///< As html, with times.

/// Creates the folder if needed.
void write_export(const std::filesystem::path& file, std::string_view bytes);
void write_export(const std::filesystem::path& file, const std::function<void(const PutPiece&)>& make);

}  // namespace rastro::cli
