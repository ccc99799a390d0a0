// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "rastro/cli/benchmark/benchmark_session.h"
#include "rastro/cli/compare/comparison.h"
#include "rastro/cli/compare/method_offers.h"

namespace rastro::cli {

/// What to compare.
struct CompareTask {
  std::vector<CompareInput> inputs;
  std::vector<MethodOffer> methods;
  std::optional<BenchmarkList> list;  ///< In place of inputs and methods.
  bool paper = false;                 ///< Each input with the methods of paper_methods() in place of these.
  int repeats = 1;
  bool quiet = false;
};

/// One comparison in one folder: finds out which methods each input allows, runs what is missing, gathers all results.
/// May be asked for further runs, as those with disturbances depend on what came before.
class CompareSession {
 public:
  /// Opens every input; the first seed of a world is simulated for that. Error for an input that cannot be opened.
  CompareSession(CompareTask task, BenchmarkSetup setup, BenchmarkTools tools, std::string data_folder);

  /// Of one input, in the order of the methods.
  const std::vector<MethodOffer>& methods_on(std::size_t input) const { return offered_[input]; }
  const std::vector<CompareInput>& inputs() const { return task_.inputs; }
  const std::vector<std::string>& refused() const { return refused_; }

  /// Every run and its command.
  std::string plan_text() const;
  /// Folder or file of each input; of a world that of its first seed.
  const std::vector<std::string>& recordings() const { return recordings_; }
  /// Of the planned runs.
  std::vector<std::string> columns() const;

  /// Adds a run to the plan: run() runs it. Of a world only with its first seed.
  void add_disturbed(std::size_t input, const MethodOffer& method, const std::string& disturbance);
  /// Runs what is missing; false: interrupted before the end.
  bool run();
  Comparison comparison() const;

 private:
  /// Facts of an input, from its recording; where that is.
  std::string look_at(CompareInput& input);
  void plan_all_methods();
  void plan_listed();
  /// Simulates the first seed of a world; where the recording is.
  std::string recording_of(const CompareInput& input) const;

  CompareTask task_;
  BenchmarkSetup setup_;
  bool forced_ = false;  ///< Former results do not count, not even of runs that are added later.
  BenchmarkTools tools_;
  std::string data_folder_;
  std::vector<std::vector<MethodOffer>> offered_;
  std::map<std::string, std::string> column_kinds_;
  std::vector<std::string> refused_, recordings_;
  ComparePlan plan_;
  std::vector<BenchmarkResult> results_;
};

}  // namespace rastro::cli
