// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "rastro/base/folder_lock.h"
#include "rastro/cli/benchmark/benchmark_parts.h"
#include "rastro/cli/benchmark/benchmark_plan.h"
#include "rastro/cli/benchmark/benchmark_result.h"

namespace rastro::cli {

/// Where and how the runs of a plan are run.
struct BenchmarkSetup {
  std::filesystem::path out;
  std::string program;                     ///< Hash of the program.
  int jobs = 1;                            ///< Runs at the same time.
  int threads = 0;                         ///< Of each run; 0: all cores.
  bool keep = true;                        ///< Simulated recordings, maps and run folders.
  bool force = false;                      ///< Run what has a result, too.
  double timeout_s = 0.0;                  ///< What each run has; those that were stopped earlier than that run again.
  std::shared_ptr<const FolderLock> lock;  ///< Keeps other calls out of the folder; null: they are not kept out.
};

/// What a benchmark needs from outside; tests have their own.
struct BenchmarkTools {
  RunProgram run;
  std::function<RunScores(const std::filesystem::path& folder, const BenchmarkJudgment& judgment,
                          const std::filesystem::path& map_folder)>
      score;
  const std::atomic<bool>* stop = nullptr;
  /// After each run, one call at a time.
  std::function<void(const BenchmarkResult& result, int done, int count)> progress;
};

/// Results of an earlier call in the same folder, and what is left to do.
struct ResumedBenchmark {
  std::vector<BenchmarkResult> results;
  std::vector<const BenchmarkRun*> missing;  ///< Of the plan, in its order.
  int other_program = 0;                     ///< Missing since their result is of another program.
  int more_time = 0;                         ///< Missing since they were stopped by a shorter limit.
  int other_command = 0;                     ///< Missing since the list says otherwise now.
  int other_files = 0;                       ///< Missing since a file that they read changed.
  int other_load = 0;                        ///< Missing since they had other threads, or more runs beside them.

  /// "12 of 40 runs have results; 3 run again: the list changed"; one line.
  std::string text() const;
};

ResumedBenchmark resume_benchmark(const BenchmarkPlan& plan, const BenchmarkSetup& setup);

/// Below `out`. Error where they cannot be made.
void make_result_folders(const std::filesystem::path& out);

/// Removes the results of these runs: they are missing then.
void forget_results(const BenchmarkPlan& plan, const BenchmarkSetup& setup);

/// Runs what is missing and saves each result when it is there. Ends early where `stop` is set. Returns all results.
std::vector<BenchmarkResult> run_missing(const BenchmarkPlan& plan, const ResumedBenchmark& resumed,
                                         const BenchmarkSetup& setup, const BenchmarkTools& tools);

}  // namespace rastro::cli
