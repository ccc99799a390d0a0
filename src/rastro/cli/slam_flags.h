// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "rastro/base/options.h"
#include "rastro/cli/run_flags.h"

namespace rastro::cli {

/// The flags of `rastro slam`.
struct SlamFlags : RunFlags {
  std::string method;   ///< Empty where `map` says it.
  std::string map;      ///< Find the way in this map, or that of this run, or go on with it; empty: make a new one.
  bool extend = false;  ///< --continue
  std::string mode = "pipelined";
  std::string mask, max_memory;                       ///< Empty = not given.
  std::string guess, loop_closing, sensor, frontend;  ///< Empty = not given; stand for the options of the same names.
  std::vector<std::string> limits;                    ///< --require
};

void add_slam_flags(CLI::App& command, SlamFlags& flags);

/// The flags of `rastro localize`, for the same run.
void add_localize_flags(CLI::App& command, SlamFlags& flags);

/// Sets the table from the options file, --set and the flags, in this order. Errors name the flag, also for a flag
/// whose option the method does not have.
void apply_settings(const SlamFlags& flags, OptionTable& table);

}  // namespace rastro::cli
