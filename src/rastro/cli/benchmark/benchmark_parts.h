// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "rastro/cli/benchmark/benchmark_plan.h"
#include "rastro/cli/benchmark/child_process.h"

namespace rastro::cli {

/// Runs one command of the program.
using RunProgram = std::function<ChildEnd(const std::vector<std::string>& words)>;

/// Why a run of the program gave no result, in one clause; empty: it did.
std::string failure_of(const ChildEnd& end);

/// The simulated recordings and maps of a plan, each made when it is first needed, and removed behind its last use
/// unless kept. May be used by several threads.
class BenchmarkParts {
 public:
  /// `runs`: those that will be run. `program`: maps of another program are made anew, as is what changed files made.
  BenchmarkParts(const BenchmarkPlan& plan, const std::vector<const BenchmarkRun*>& runs, std::filesystem::path out,
                 std::string program, bool keep, RunProgram run_program);

  /// Makes what the run needs and is not there. Why that failed; empty: it did not.
  std::string need(const BenchmarkRun& run);
  void release(const BenchmarkRun& run);

 private:
  struct State {
    std::mutex making;
    bool made = false;
    std::string failure;
    int uses = 0;
  };

  std::vector<std::string> folders_of(const BenchmarkRun& run) const;
  std::string need(const std::string& folder);
  std::string make(const BenchmarkPart& part);
  std::string mark_of(const BenchmarkPart& part) const;
  std::filesystem::path mark_file(const std::string& folder) const { return out_ / (folder + ".made"); }

  const BenchmarkPlan& plan_;
  std::filesystem::path out_;
  std::string program_;
  bool keep_;
  RunProgram run_program_;
  std::map<std::string, State> states_;  ///< None is added after construction.
};

}  // namespace rastro::cli
