// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/cli/benchmark/benchmark_run.h"

namespace rastro::cli {

/// The flags of every command that runs a plan.
struct SessionFlags {
  std::string out;
  int jobs = 1;
  int threads = 0;
  bool force = false;
  double timeout_s = 3600.0;
};

/// Checks the flags. Hashes the program: its results are those of this very program.
BenchmarkSetup benchmark_setup(const SessionFlags& flags, bool keep);

/// Runs this program, judges by score_run() and stops at Ctrl-C. A line on standard error after each run unless quiet.
BenchmarkTools benchmark_tools(const BenchmarkSetup& setup, bool quiet);

/// Where recordings lie: `given`, else $RASTRO_DATA, else ../shared/data.
std::string data_folder(const std::string& given);

}  // namespace rastro::cli
