// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "rastro/cli/benchmark/benchmark_plan.h"
#include "rastro/cli/benchmark/benchmark_result.h"
#include "rastro/cli/benchmark/benchmark_run.h"
#include "rastro/cli/compare/compare_input.h"
#include "rastro/cli/compare/compare_plan.h"
#include "rastro/cli/compare/result_table.h"
#include "rastro/cli/compare/strength_curve.h"
#include "rastro/export/track_table.h"

namespace rastro::cli {

/// A run of the plan with its result.
struct FinishedRun {
  CompareRun what;
  std::uint64_t seed = 0;  ///< Of the world; 0 for a recording.
  BenchmarkResult result;
  std::filesystem::path folder;
  std::string recording;         ///< What it read.
  std::string ground_truth;      ///< Empty: none.
  std::string run_command;       ///< As it can be typed.
  std::string evaluate_command;  ///< Gives the errors; empty where there is no ground truth.

  /// In the table of methods: neither repeated for its bytes nor disturbed.
  bool is_plain() const { return !what.again && what.disturbance.empty(); }
  bool failed() const { return !result.failure.empty(); }
};

/// A trajectory of another program.
struct ImportedTrajectory {
  std::size_t input = 0;
  std::string column;
  std::uint64_t seed = 0;
  std::string trajectory, ground_truth, alignment;
  std::string command;   ///< Gives its errors.
  bool of_body = false;  ///< Poses of the body instead of the camera.
};

/// How one tracker did on one input, as in Table I of the front-end paper.
struct FrontEndFigures {
  std::size_t input = 0;
  std::string tracker;  ///< "klt", "paper", "default".
  TrackTableMeans means;
  std::string command;  ///< Writes the same table.
};

/// What all reports are made from.
struct Comparison {
  std::vector<CompareInput> inputs;
  std::vector<std::string> refused;  ///< "kitchen: hector: has no laser scans", one each.
  std::vector<FinishedRun> runs;     ///< In the order of the plan.
  std::size_t planned = 0;           ///< More than `runs` where the comparison was interrupted.
  ResultTable table;
  std::string command;                              ///< Of the comparison itself.
  std::map<std::string, std::string> column_kinds;  ///< "mono", "stereo", "depth" or "laser" of each method.
  std::vector<ImportedTrajectory> imported;
  std::vector<StrengthCurve> strengths;  ///< Of --disturb; empty without.
  bool paper = false;                    ///< Also beside the figures of the papers.
  std::vector<FrontEndFigures> front_end;
};

/// Of --jobs: 1 where each run had the machine for itself, so that its times are those of the method.
int runs_at_once(const Comparison& comparison);

/// "interrupted: 3 of 12 runs have results"; empty where all have.
std::string interruption_text(const Comparison& comparison);

/// The results in the order of the plan; `plan`: of `planned.list`.
std::vector<FinishedRun> finished_runs(const ComparePlan& planned, const BenchmarkPlan& plan,
                                       const std::vector<BenchmarkResult>& results, const BenchmarkSetup& setup);

/// The figures of every plain run, and same_bytes_percent of those repeated.
ResultTable table_of(const std::vector<CompareInput>& inputs, const std::vector<FinishedRun>& runs);

}  // namespace rastro::cli
