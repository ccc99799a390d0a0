// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/session/run_folder.h"
#include "rastro/session/slam_run.h"

namespace rastro::cli {

/// Writes trajectory.txt and the files of the map, and sets the hash of the result, which is over all of them but the
/// picture.
void write_slam_outputs(SlamRunEnd& end, const RunFolder& folder);

/// What a person wants to know of the run.
std::string slam_summary(const SlamRunEnd& end, const std::string& folder);

}  // namespace rastro::cli
