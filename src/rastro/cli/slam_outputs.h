// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/session/run_folder.h"
#include "rastro/session/slam_run.h"
#include "rastro/slam/slam_method.h"

namespace rastro::cli {

/// Whether a run makes (or continues) a map, or localizes in one.
enum class SlamTask { map, localize };

/// What was written, for slam_summary().
struct SlamOutputs {
  std::vector<std::string> files;  ///< Names, in order.
  bool lacks_cloud = false;        ///< The run was interrupted, and cloud.ply takes long.
  std::string grid;                ///< Size of the occupancy grid, such as "9.5 x 4.0 m in cells of 0.05 m"; or empty.
};

/// Writes trajectory.txt and the files that the layers of the map give, and sets the hash of the result, which is over
/// trajectory.txt, map.pgm, map.yaml, landmarks.csv, keyframes.txt and map.rastro, in this order, those that there are;
/// not over images and clouds, which are made from the map. When localizing, the trajectory alone.
SlamOutputs write_slam_outputs(SlamRunEnd& end, const RunFolder& folder, const SlamContext& context, SlamTask task);

/// Summary of the run.
std::string slam_summary(const SlamRunEnd& end, const SlamOutputs& outputs, const std::string& folder, SlamTask task);

}  // namespace rastro::cli
