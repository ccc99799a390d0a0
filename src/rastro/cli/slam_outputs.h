// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/base/task_pool.h"
#include "rastro/session/run_folder.h"
#include "rastro/session/slam_run.h"

namespace rastro::cli {

/// What a run was for: a map of its own, or to find the way in one made before.
enum class SlamTask { map, localize };

/// Writes trajectory.txt and the files of the map, and sets the hash of the result, which is over all of them but what
/// is made from the map file: pictures and clouds.
void write_slam_outputs(SlamRunEnd& end, const RunFolder& folder, SlamTask task, TaskPool* pool);

/// What a person wants to know of the run.
std::string slam_summary(const SlamRunEnd& end, const std::string& folder, SlamTask task);

}  // namespace rastro::cli
