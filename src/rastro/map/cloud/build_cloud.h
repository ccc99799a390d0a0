// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

#include "rastro/base/task_pool.h"
#include "rastro/map/cloud/point_cloud.h"
#include "rastro/map/graph/map.h"

namespace rastro {

struct CloudOptions {
  double voxel_m = 0.01;  ///< One point per voxel; > 0.
  int stride = 2;         ///< Every stride-th pixel of every stride-th row, >= 1.
  double min_depth_m = 0.3, max_depth_m = 5.0;
  double grazing_deg = 80.0;  ///< Maximum angle between ray and normal; surfaces at a more grazing angle are left out.
  int submap = 0;             ///< Keyframes of this submap; -1: of all, each in the frame of its own submap.
  int min_count = 3;          ///< Points with fewer measurements are left out.
  int min_views = 1;          ///< So are points observed from fewer keyframes.
  /// If a map needs more voxels, their side is doubled; PointCloud::voxel_m gives the final side. Each takes about 100
  /// bytes of memory.
  std::size_t max_voxels = 4'000'000;
  std::size_t keyframes_at_once = 8;  ///< Their measurements are in memory; > 0.
};

/// How far the depth of the map's first camera is used: 5 m with a depth camera; with a stereo pair as far as its sigma
/// is below 3 % of the depth.
double precise_depth_m(const Map& map);
/// The defaults, with voxels and depth in proportion to precise_depth_m().
CloudOptions cloud_options_for(const Map& map);
/// So that build_cloud() takes no more memory than about `bytes`, or than a coarse cloud needs, and then its file.
void keep_within(std::size_t bytes, const Map& map, CloudOptions& options);

/// Receives the number of keyframes done and their total.
using MapProgress = std::function<void(std::size_t done, std::size_t all)>;

/// The surfaces observed by the keyframes: their depth images transformed by the keyframe poses. Measurements are
/// weighted by 1 / sigma(z)^2. Layers that noise spreads over several voxels along the normal are merged into one, and
/// points whose measurements contradict each other are left out. The sigma of a point counts the measurements of one
/// keyframe in a voxel as one, since their noise is not independent. It grows where they scatter more than the noise
/// model predicts. The same bytes for any pool. Error where images cannot be read.
PointCloud build_cloud(const Map& map, const CloudOptions& options, TaskPool* pool = nullptr,
                       const MapProgress& progress = {});

}  // namespace rastro
