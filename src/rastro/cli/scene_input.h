// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/cli/export_input.h"
#include "rastro/viewer/build_scene.h"
#include "rastro/viewer/point_tiles.h"
#include "rastro/viewer/run_record.h"
#include "rastro/viewer/scene.h"

namespace rastro::cli {

/// What `rastro view` and `rastro export --to html` show of an input, as the page reads it: its map, what the run noted
/// of its frames, and lengths: those of the file `objects`, measured in the map, and of lengths.json of the run. Error
/// for a file of the run that is damaged, and for images that cannot be read.
NamedScene scene_of(const ExportInput& input, const ViewSceneOptions& options, TaskPool& pool,
                    const MapProgress& progress, const std::string& objects = "");

/// The same for a server: points of layers with more than a million are fetched in tiles.
NamedScene served_scene_of(const ExportInput& input, const ViewSceneOptions& options, TaskPool& pool,
                           const MapProgress& progress, const TileProgress& tiling, const std::string& objects = "");
NamedScene in_tiles(ViewScene scene, const TileProgress& progress);

/// The same as arrays, with the notes of the run (notes_of_run) given.
ViewScene view_scene_of(const ExportInput& input, RunRecord record, const ViewSceneOptions& options, TaskPool& pool,
                        const MapProgress& progress);

/// Unit vector that points up in the world of these poses of a camera (x right, y down): the mean of its own.
std::array<double, 3> up_of(const Trajectory& trajectory, bool planar);

/// How an input is called in the page: the folder of a run, or the file's name without its extension.
std::string scene_name(const std::string& path);

/// The flags of both commands about what is shown.
struct SceneFlags {
  std::optional<std::int64_t> points;
  bool mesh = false, octree = false;
  std::string objects;  ///< Lengths to measure, as of `rastro measure`; empty: none.
};

/// Error for a number of points out of range. `default_points` where none is given.
ViewSceneOptions scene_options(const SceneFlags& flags, int submap, std::size_t default_points);

}  // namespace rastro::cli
