// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace rastro::cli {

/// What a run gave, judged by the ground truth; empty where it gave no result.
struct RunScores {
  std::int64_t frames = 0;       ///< Processed or skipped.
  std::int64_t tracked = 0;      ///< In state tracking, weak or relocalized.
  std::int64_t posed = 0;        ///< With a pose in the end, also those placed once a relocalization was confirmed.
  std::int64_t false_poses = 0;  ///< Of the tracked, further off the ground truth than the limit.
  std::int64_t false_poses_lost =
      0;                        ///< The same of frames lost or not yet initialized, which got a pose all the same.
  std::optional<double> ate_m;  ///< Absolute trajectory error, or mean error of relations; none: not to be judged.
  /// Share of the poses inside their ellipse of 95 %; none: the run gives no covariances.
  std::optional<double> inside_position_percent, inside_rotation_percent;
  bool warned = false;                    ///< The program said that something is wrong with the input or the result.
  std::string sha256;                     ///< Of its trajectory and map.
  std::string alignment;                  ///< "se3", "sim3" or "yaw"; empty: none was needed or possible.
  std::string first_loss;                 ///< "frame 12: few_points"; empty: tracking was never lost.
  std::map<std::string, double> figures;  ///< Further ones by name and unit, see run_figures.h.
};

/// The result of one run, kept as one JSON file.
struct BenchmarkResult {
  std::string entry;
  std::uint64_t seed = 0;
  std::string command;  ///< See BenchmarkPlan::command_of().
  std::string program;  ///< Hash of the program that ran.
  std::string files;    ///< BenchmarkRun::files, before the run.
  int jobs = 0;         ///< Runs at the same time, and threads of each: they decide its times. 0: unknown; all cores.
  int threads = 0;
  std::string failure;     ///< Why there is no result; empty: there is one, or the program rightly refused wrong input.
  std::string message;     ///< Last line of the program on standard error.
  bool timed_out = false;  ///< Stopped after wall_s.
  RunScores scores;
  double wall_s = 0.0, cpu_s = 0.0, peak_memory_mb = 0.0;
};

std::string to_json(const BenchmarkResult& result);
/// nullopt where there is no such file, or it is none of these.
std::optional<BenchmarkResult> read_benchmark_result(const std::filesystem::path& file);

}  // namespace rastro::cli
