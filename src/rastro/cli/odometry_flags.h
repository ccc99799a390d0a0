// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "rastro/base/options.h"
#include "rastro/cli/run_flags.h"

namespace rastro::cli {

/// The flags of `rastro odometry`.
struct OdometryFlags : RunFlags {
  std::string method = "features";
  std::string matcher;  ///< Empty: not given; sets the option of the same name.
  std::string scale;    ///< camera-height=METERS or reference=FILE; empty: relative.
  bool calibrate_yaw = false;
  std::string reference;  ///< Trajectory for calibrate_yaw.
  bool refine = false;
  bool no_refine = false;
};

void add_odometry_flags(CLI::App& command, OdometryFlags& flags);

/// Sets the table from the options file, --set and the flags, in this order. Errors name the flag.
void apply_settings(const OdometryFlags& flags, OptionTable& table);

}  // namespace rastro::cli
