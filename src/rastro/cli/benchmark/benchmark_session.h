// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
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

/// Makes the folder and keeps other calls out of it, whose worlds and maps would take the place of ours while runs read
/// them. Error where another one has it.
std::shared_ptr<const FolderLock> claim_results(const std::filesystem::path& out);

/// Checks the flags and claims the folder. Hashes the program: its results are those of this very program.
BenchmarkSetup benchmark_setup(const SessionFlags& flags, bool keep);

/// Runs this program, judges by score_run() and stops at Ctrl-C. A line on standard error after each run unless quiet.
BenchmarkTools benchmark_tools(const BenchmarkSetup& setup, bool quiet);

/// Where recordings lie: `given`, else $RASTRO_DATA, else ../shared/data.
std::string data_folder(const std::string& given);

}  // namespace rastro::cli
