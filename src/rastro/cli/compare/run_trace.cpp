// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/run_trace.h"

#include <algorithm>
#include <set>

#include "rastro/base/error.h"
#include "rastro/cli/benchmark/run_scores.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

constexpr TimeNs pair_within = 20'000'000;  ///< As 'rastro evaluate trajectory'.
constexpr int fewest_common_frames = 10;

TrajectoryScoreOptions options_of(TrajectoryAlignment alignment) {
  TrajectoryScoreOptions options;
  options.alignment = alignment;
  options.max_difference = pair_within;
  return options;
}

/// By the index of the pose of the reference: the stamp of the pose that was matched with it while tracking.
std::map<std::size_t, TimeNs> tracked_pairs(const RunTrace& trace) {
  std::map<std::size_t, TimeNs> tracked;
  for (const PosePair& pair : trace.scores.pairs) {
    const TimeNs stamp = trace.estimate.poses[pair.estimate].stamp;
    if (trace.is_tracked(stamp)) tracked[pair.reference] = stamp;
  }
  return tracked;
}

TrajectoryInput only(const std::vector<std::size_t>& poses, const TrajectoryInput& all) {
  TrajectoryInput chosen = all;
  chosen.poses.clear(), chosen.matrices.clear();
  for (const std::size_t k : poses) {
    chosen.poses.push_back(all.poses[k]);
    chosen.matrices.push_back(all.matrices[k]);
  }
  return chosen;
}

/// Of the poses of the estimate with these stamps. The reference is cut as well: poses without stamps are matched by
/// their number.
double error_at(const RunTrace& trace, const std::set<TimeNs>& stamps) {
  std::vector<std::size_t> of_reference, of_estimate;
  for (const PosePair& pair : trace.scores.pairs) {
    if (!stamps.contains(trace.estimate.poses[pair.estimate].stamp)) continue;
    of_reference.push_back(pair.reference);
    of_estimate.push_back(pair.estimate);
  }
  const TrajectoryInput& reference = trace.reference->input;
  return score_trajectory(only(of_reference, reference), only(of_estimate, trace.estimate), options_of(trace.alignment))
      .ate_m->rmse;
}

}  // namespace

std::vector<double> RunTrace::times_s() const {
  std::vector<double> times;
  const Trajectory& poses = reference->input.poses;
  for (const PosePair& pair : scores.pairs)
    times.push_back(to_seconds(poses[pair.reference].stamp - poses.front().stamp));
  return times;
}

std::vector<double> RunTrace::errors_m() const {
  std::vector<double> errors;
  for (std::size_t k = 0; k < scores.pairs.size(); ++k) {
    const Eigen::Vector3d& is = scores.aligned[k].world_from_body.translation();
    errors.push_back((is - reference->input.poses[scores.pairs[k].reference].world_from_body.translation()).norm());
  }
  return errors;
}

double RunTrace::posed_percent(std::int64_t of_frames) const {
  if (of_frames <= 0 || !estimate.has_stamps) return scores.pairing.coverage_percent;
  const Trajectory& truth = reference->input.poses;
  const auto is_within = [&](const StampedPose& pose) {
    return pose.stamp >= truth.front().stamp - pair_within && pose.stamp <= truth.back().stamp + pair_within;
  };
  const auto posed = std::count_if(estimate.poses.begin(), estimate.poses.end(), is_within);
  return std::min(100.0, 100.0 * static_cast<double>(posed) / static_cast<double>(of_frames));
}

std::optional<RunTrace> TraceReader::read(const std::string& estimate, const std::string& ground_truth,
                                          const std::string& alignment, const std::string& frames, bool of_body) {
  if (ground_truth.empty() || alignment.empty()) return std::nullopt;
  auto& reference = references_[{ground_truth, frames, of_body}];
  TrajectoryFileFlags files;
  files.frames = frames;
  if (of_body) files.estimate_of = "body";
  if (!reference)
    reference = std::make_shared<const ReferenceTrajectory>(read_reference(poses_beside(ground_truth), files));
  RunTrace trace;
  trace.reference = reference;
  trace.estimate = read_estimate(estimate, *reference, {});
  trace.alignment = parse_alignment(alignment);
  try {
    trace.scores = score_trajectory(reference->input, trace.estimate, options_of(trace.alignment));
  } catch (const Error&) {
    return std::nullopt;  // no pose of it can be matched or aligned
  }
  const fs::path stats = fs::path(estimate) / "stats.csv";
  std::error_code ignored;
  if (fs::is_regular_file(stats, ignored)) trace.frames = read_run_frames(stats);
  return trace;
}

std::optional<CommonErrors> errors_on_common_frames(const RunTrace& first, const RunTrace& second) {
  const auto of_first = tracked_pairs(first), of_second = tracked_pairs(second);
  std::set<TimeNs> first_stamps, second_stamps;
  for (const auto& [reference, stamp] : of_first) {
    const auto found = of_second.find(reference);
    if (found == of_second.end()) continue;
    first_stamps.insert(stamp);
    second_stamps.insert(found->second);
  }
  const int frames = static_cast<int>(first_stamps.size());
  if (frames < fewest_common_frames) return std::nullopt;
  try {
    return CommonErrors{error_at(first, first_stamps), error_at(second, second_stamps), frames};
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace rastro::cli
