// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rastro/cli/benchmark/benchmark_session.h"
#include "rastro/cli/compare/compare_session.h"

namespace rastro::cli {

/// As given to 'rastro compare'.
struct CompareFlags {
  std::vector<std::string> inputs, methods;
  std::string data, frames, intrinsics, calibration, fov, rate, every;
  std::uint64_t seeds = 1;
  bool seeds_given = false;
  std::optional<double> timeout_s;
  int repeats = 1;
  std::vector<std::string> disturbances, imports;
  SessionFlags session;
  bool paper = false, dry_run = false, quiet = false;
};

/// Inputs and methods, or the list in their place. Error for what is wrong, as for flags that a list does not heed.
CompareTask task_of(const CompareFlags& flags, const std::string& data);

/// How the runs of the task run: as the list says where the flags do not.
SessionFlags session_of(const CompareFlags& flags, const CompareTask& task);

}  // namespace rastro::cli
