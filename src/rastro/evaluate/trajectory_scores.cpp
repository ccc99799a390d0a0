// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/trajectory_scores.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/math/alignment.h"

namespace rastro {
namespace {

constexpr std::array<const char*, 5> alignment_names = {"none", "se3", "sim3", "yaw", "origin"};
constexpr double degrees = 180.0 / std::numbers::pi;

bool by_index(const TrajectoryInput& reference, const TrajectoryInput& estimate) {
  if (reference.format != TrajectoryFormat::kitti || estimate.format != TrajectoryFormat::kitti) return false;
  return reference.poses.size() == estimate.poses.size() || !reference.has_stamps || !estimate.has_stamps;
}

void require_stamps(const TrajectoryInput& input, const TrajectoryInput& other) {
  if (input.has_stamps) return;
  throw Error(fmt::format("has poses without stamps, while {} has stamps", other.file), input.file,
              "put KITTI's times.txt beside it or give --times FILE");
}

std::string span_of(const Trajectory& poses) {
  return fmt::format("{:.3f} to {:.3f} s", to_seconds(poses.front().stamp), to_seconds(poses.back().stamp));
}

std::vector<PosePair> pair_poses(const TrajectoryInput& reference, const TrajectoryInput& estimate,
                                 TimeNs max_difference) {
  if (by_index(reference, estimate)) return pair_by_index(reference.poses, estimate.poses);
  require_stamps(reference, estimate);
  require_stamps(estimate, reference);
  auto pairs = pair_by_stamp(reference.poses, estimate.poses, max_difference);
  if (pairs.empty())
    throw Error(fmt::format("no pose is within {:g} s of one of {}: stamps {} against {}", to_seconds(max_difference),
                            reference.file, span_of(estimate.poses), span_of(reference.poses)),
                estimate.file, "check that both are of one recording, or raise --max-dt");
  return pairs;
}

PairedPoses paired(const TrajectoryInput& reference, const TrajectoryInput& estimate,
                   const std::vector<PosePair>& pairs) {
  PairedPoses poses;
  for (const PosePair& pair : pairs) {
    poses.reference.push_back(reference.matrices[pair.reference]);
    poses.estimate.push_back(estimate.matrices[pair.estimate]);
    // Of two files associated by line, either may have the stamps.
    if (reference.has_stamps)
      poses.stamps.push_back(reference.poses[pair.reference].stamp);
    else if (estimate.has_stamps)
      poses.stamps.push_back(estimate.poses[pair.estimate].stamp);
  }
  return poses;
}

std::vector<Eigen::Vector3d> positions(const std::vector<Eigen::Matrix4d>& poses) {
  std::vector<Eigen::Vector3d> all;
  for (const Eigen::Matrix4d& pose : poses) all.push_back(pose.topRightCorner<3, 1>());
  return all;
}

/// The alignment; the same for all of `poses`.
void align_with(const Sim3& reference_from_estimate, PairedPoses& poses, TrajectoryScores& scores) {
  scores.reference_from_estimate = reference_from_estimate;
  const Eigen::Matrix3d rotation = reference_from_estimate.rotation().matrix();
  for (Eigen::Matrix4d& pose : poses.estimate) {
    const Eigen::Vector3d position = pose.topRightCorner<3, 1>();
    pose.topLeftCorner<3, 3>() = (rotation * pose.topLeftCorner<3, 3>()).eval();
    pose.topRightCorner<3, 1>() = reference_from_estimate * position;
  }
}

Sim3 origin_alignment(const PairedPoses& poses) {
  return Sim3(SE3::from_matrix(poses.reference.front()) * SE3::from_matrix(poses.estimate.front()).inverse());
}

void align(PairedPoses& poses, TrajectoryScores& scores) {
  if (scores.alignment == TrajectoryAlignment::none) return;
  if (scores.alignment == TrajectoryAlignment::origin) {
    align_with(origin_alignment(poses), poses, scores);
    return;
  }
  const AlignmentKind kind = scores.alignment == TrajectoryAlignment::yaw    ? AlignmentKind::yaw
                             : scores.alignment == TrajectoryAlignment::sim3 ? AlignmentKind::similarity
                                                                             : AlignmentKind::rigid;
  const auto found = align_points(positions(poses.reference), positions(poses.estimate), kind);
  if (!found)
    throw Error(fmt::format("cannot be aligned with the reference by --align {}: one of the two does not move",
                            name_of(scores.alignment)),
                scores.estimate, "use --align se3 or none");
  scores.alignment_unique = found->unique;
  align_with(found->target_from_source, poses, scores);
}

void measure_relative(const PairedPoses& poses, const TrajectoryScoreOptions& options, TrajectoryScores& scores) {
  for (const RpeDelta& delta : options.rpe_deltas) {
    std::vector<double> translations, rotations;
    for (const RelativeError& error : relative_errors(poses, delta, options.rpe_all_pairs)) {
      translations.push_back(error.translation_m);
      rotations.push_back(degrees * error.rotation_rad);
    }
    scores.rpe.push_back({delta, statistics_of(translations), statistics_of(rotations)});
  }
}

void measure_segments(const PairedPoses& poses, const TrajectoryScoreOptions& options, TrajectoryScores& scores) {
  scores.segments = segment_errors(poses, options.segments_m);
  double translation = 0.0, rotation = 0.0;
  for (const SegmentErrors& segments : scores.segments) {
    scores.segment_count += segments.count;
    translation += segments.count * segments.translation_percent;
    rotation += segments.count * segments.rotation_deg_per_m;
  }
  if (scores.segment_count == 0) return;
  scores.t_rel_percent = translation / scores.segment_count;
  scores.r_rel_deg_per_m = rotation / scores.segment_count;
}

void measure_paths(const PairedPoses& poses, TrajectoryScores& scores) {
  scores.reference_path_m = path_lengths(poses.reference).back();
  scores.estimate_path_m = path_lengths(poses.estimate).back();
  if (!(scores.reference_path_m > 0.0)) return;
  const RelativeError whole = relative_error(poses, 0, poses.reference.size() - 1);
  scores.drift_percent = 100.0 * whole.translation_m / scores.reference_path_m;
  scores.drift_deg_per_m = degrees * whole.rotation_rad / scores.reference_path_m;
}

void describe_pairs(const TrajectoryInput& reference, const TrajectoryInput& estimate, TrajectoryScores& scores) {
  scores.reference = reference.file;
  scores.estimate = estimate.file;
  scores.pairing.reference_poses = static_cast<int>(reference.poses.size());
  scores.pairing.estimate_poses = static_cast<int>(estimate.poses.size());
  scores.pairing.matched = static_cast<int>(scores.pairs.size());
  scores.pairing.by_index = by_index(reference, estimate);
  scores.pairing.coverage_percent =
      100.0 * coverage_of(reference.poses, estimate.poses, scores.pairs, scores.pairing.by_index);
  if (scores.pairing.by_index) return;
  TimeNs largest = 0;
  for (const PosePair& pair : scores.pairs)
    largest = std::max(largest, std::abs(reference.poses[pair.reference].stamp - estimate.poses[pair.estimate].stamp));
  scores.pairing.largest_difference_s = to_seconds(largest);
}

}  // namespace

const char* name_of(TrajectoryAlignment alignment) { return alignment_names[static_cast<std::size_t>(alignment)]; }

TrajectoryAlignment parse_alignment(const std::string& name) {
  for (std::size_t k = 0; k < alignment_names.size(); ++k)
    if (name == alignment_names[k]) return static_cast<TrajectoryAlignment>(k);
  throw Error(in_quotes(name) + " is not an alignment", "--align", "use none, se3, sim3, yaw or origin");
}

TrajectoryScores score_trajectory(const TrajectoryInput& reference, const TrajectoryInput& estimate,
                                  const TrajectoryScoreOptions& options) {
  TrajectoryScores scores;
  scores.pairs = pair_poses(reference, estimate, options.max_difference);
  scores.alignment = options.alignment;
  describe_pairs(reference, estimate, scores);
  PairedPoses poses = paired(reference, estimate, scores.pairs);
  align(poses, scores);
  scores.ate_m = statistics_of(position_errors(poses));
  measure_relative(poses, options, scores);
  measure_segments(poses, options, scores);
  measure_paths(poses, scores);
  for (std::size_t k = 0; k < scores.pairs.size(); ++k)
    scores.aligned.push_back({reference.poses[scores.pairs[k].reference].stamp, SE3::from_matrix(poses.estimate[k])});
  return scores;
}

}  // namespace rastro
