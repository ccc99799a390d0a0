// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "rastro/cli/benchmark/run_frames.h"
#include "rastro/cli/trajectory_files.h"
#include "rastro/evaluate/trajectory_scores.h"

namespace rastro::cli {

/// The poses of a run, or of an imported trajectory, aligned with its ground truth.
struct RunTrace {
  std::shared_ptr<const ReferenceTrajectory> reference;
  TrajectoryInput estimate;
  TrajectoryAlignment alignment = TrajectoryAlignment::se3;
  TrajectoryScores scores;
  std::vector<RunFrame> frames;  ///< Empty for an imported trajectory: every pose counts as tracked.

  /// Seconds from the first pose of the reference, and the distance from it, of each matched pose.
  std::vector<double> times_s() const;
  std::vector<double> errors_m() const;
  /// Share of the frames of the input with a pose, whether it was tracked or placed later; `frames`: their number,
  /// 0: unknown, then of the poses of the ground truth.
  double posed_percent(std::int64_t frames) const;
  bool is_tracked(TimeNs stamp) const { return frames.empty() || was_tracked(frames, stamp); }
};

/// Reads traces, and each ground truth only once.
class TraceReader {
 public:
  /// `estimate`: run folder or trajectory file. `frames`: A:B of the recording, empty: all. nullopt where there is no
  /// ground truth of poses or no trajectory to align with it.
  std::optional<RunTrace> read(const std::string& estimate, const std::string& ground_truth,
                               const std::string& alignment, const std::string& frames, bool of_body = false);

 private:
  std::map<std::tuple<std::string, std::string, bool>, std::shared_ptr<const ReferenceTrajectory>> references_;
};

/// Absolute trajectory errors (rmse) of two runs on the same input over the frames that both tracked, each with its own
/// alignment over just these; nullopt where these are fewer than ten.
struct CommonErrors {
  double first_m = 0.0, second_m = 0.0;
  int frames = 0;
};
std::optional<CommonErrors> errors_on_common_frames(const RunTrace& first, const RunTrace& second);

}  // namespace rastro::cli
