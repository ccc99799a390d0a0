// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/session/run_folder.h"
#include "rastro/session/slam_run.h"
#include "rastro/slam/slam_method.h"

namespace rastro::cli {

/// What a run was for: a map of its own, or to find the way in one made before.
enum class SlamTask { map, localize };

/// Writes trajectory.txt and the files of the map, and sets the hash of the result, which is over all of them but what
/// is made from the map file: pictures and clouds. Of a run in a map made before, the trajectory alone.
void write_slam_outputs(SlamRunEnd& end, const RunFolder& folder, const SlamMeans& means, SlamTask task);

/// What a person wants to know of the run.
std::string slam_summary(const SlamRunEnd& end, const std::string& folder, SlamTask task);

}  // namespace rastro::cli
