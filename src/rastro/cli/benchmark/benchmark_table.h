// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "rastro/cli/benchmark/benchmark_list.h"
#include "rastro/cli/benchmark/benchmark_result.h"
#include "rastro/synthetic/disturbance/disturbance.h"

namespace rastro::cli {

/// One line of the table: the runs of an entry over its seeds.
struct BenchmarkRow {
  std::string name;
  int runs = 0, planned = 0;  ///< With a result or a failure; of the list.
  int failed = 0, warned = 0;
  WarningDue warning_due = WarningDue::no;          ///< Of the input; no: a warning is a false alarm.
  std::optional<double> median_ate_m, worst_ate_m;  ///< None: no run could be judged.
  std::optional<double> inside_position_percent, inside_rotation_percent;  ///< Means over the runs with covariances.
  double tracked_percent = 0.0;                                            ///< Over the frames of all runs.
  std::int64_t false_poses = 0, false_poses_lost = 0;
  double ms_per_frame = 0.0, cpu_ms_per_frame = 0.0;  ///< Medians over the runs; the whole program, reading included.
  double peak_memory_mb = 0.0;                        ///< The largest.
  std::string failure;                                ///< The first.
};

using BenchmarkRows = std::vector<BenchmarkRow>;

/// One row per entry, in the order of the list.
BenchmarkRows rows_of(const BenchmarkList& list, const std::vector<BenchmarkResult>& results);

std::string to_json(const BenchmarkRows& rows);
/// Error where the file is not one that to_json() gives.
BenchmarkRows read_benchmark_rows(const std::filesystem::path& file);

/// The table; with a baseline each value that differs from it has the former one behind it.
std::string table_text(const BenchmarkRows& rows, const BenchmarkRows& baseline);

/// One line per value of a completed row that is worse than the baseline beyond the tolerance, with both values.
std::vector<std::string> worse_than(const BenchmarkRows& rows, const BenchmarkRows& baseline,
                                    const BenchmarkTolerance& tolerance);

/// How many rows worse_than() compares: complete ones that the baseline has too.
int compared_with(const BenchmarkRows& rows, const BenchmarkRows& baseline);

/// How many runs with wrong input warned, and how many with right input; one line.
std::string warnings_text(const BenchmarkRows& rows);

/// What localization was expected to find and did, in one line; empty without such entries.
std::string expectations_text(const BenchmarkList& list, const std::vector<BenchmarkResult>& results);

}  // namespace rastro::cli
