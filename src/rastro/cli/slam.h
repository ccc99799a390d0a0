// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/cli/slam_flags.h"

namespace rastro::cli {

/// `rastro slam`, and `rastro localize` where the flags name a map. The exit code.
int run_slam(const SlamFlags& flags);

}  // namespace rastro::cli
