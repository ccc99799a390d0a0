// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/options.h"
#include "rastro/cli/run_flags.h"
#include "rastro/math/se3.h"
#include "rastro/slam/slam_method.h"

namespace rastro::cli {

/// The flags of `rastro slam`.
struct SlamFlags : RunFlags {
  std::string method;   ///< Empty: that of `map`.
  std::string map;      ///< Localize in this map (or that of this run), or continue it; empty: make a new one.
  bool extend = false;  ///< --continue
  std::string mode = "pipelined";
  std::string mask, max_memory, initial_pose;         ///< Empty: not given.
  std::string guess, loop_closing, sensor, frontend;  ///< Empty: not given; set the options of the same names.
  std::vector<std::string> limits;                    ///< --require
};

void add_slam_flags(CLI::App& command, SlamFlags& flags);

/// The flags of `rastro localize`, for the same run.
void add_localize_flags(CLI::App& command, SlamFlags& flags);

/// "x,y,z" or "x,y,z,roll,pitch,yaw" in meters and degrees, the rotation yaw * pitch * roll about z, y and x; of a
/// planar method also "x,y,yaw", which takes the place of "x,y,z". nullopt for empty text; Error for any other.
std::optional<SE3> parse_initial_pose(const std::string& text, bool planar);

/// The values of --preset. Error for one that the method does not have.
void apply_preset(const SlamFlags& flags, SlamMethod& method);
/// Sets the table from the options file, --set and the flags, in this order. Errors name the flag, also for a flag
/// whose option the method does not have.
void apply_settings(const SlamFlags& flags, const std::string& method, OptionTable& table);

}  // namespace rastro::cli
