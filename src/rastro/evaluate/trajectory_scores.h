// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rastro/evaluate/pose_consistency.h"
#include "rastro/evaluate/trajectory_errors.h"
#include "rastro/evaluate/trajectory_input.h"
#include "rastro/evaluate/trajectory_pairs.h"
#include "rastro/math/sim3.h"

namespace rastro {

/// Alignment of the estimate with the reference before the comparison, over all matched positions (math/alignment.h).
enum class TrajectoryAlignment : std::uint8_t {
  none,
  se3,     ///< Rotation and translation.
  sim3,    ///< Scale too: for one camera, whose scale is arbitrary.
  yaw,     ///< Rotation about the reference's z axis and translation: for systems with observable gravity.
  origin,  ///< The first matched pose of both is the same: errors grow from there.
};
const char* name_of(TrajectoryAlignment alignment);
/// Throws Error for any other name.
TrajectoryAlignment parse_alignment(const std::string& name);

struct TrajectoryScoreOptions {
  TrajectoryAlignment alignment = TrajectoryAlignment::se3;
  TimeNs max_difference = 20'000'000;  ///< Poses with a larger difference of stamps are not matched.
  std::vector<double> segments_m = {100, 200, 300, 400, 500, 600, 700, 800};
  std::vector<RpeDelta> rpe_deltas = {
      {1.0, RpeDelta::Unit::frames}, {1.0, RpeDelta::Unit::seconds}, {1.0, RpeDelta::Unit::meters}};
  bool rpe_all_pairs = false;
};

struct RpeScores {
  RpeDelta delta;
  std::optional<ErrorStatistics> translation_m;
  std::optional<ErrorStatistics> rotation_deg;
};

/// How the poses of both sides were associated.
struct PosePairing {
  int reference_poses = 0, estimate_poses = 0, matched = 0;
  bool by_index = false;              ///< By line: both are KITTI files, of one length or without stamps.
  double largest_difference_s = 0.0;  ///< Largest difference of stamps in a pair.
  double coverage_percent = 0.0;      ///< See coverage_of().
};

/// Scores of an estimate against a reference. Everything but `scale()` and `reference_from_estimate` is measured after
/// the alignment; relative errors and segments depend on it only by the scale.
struct TrajectoryScores {
  std::string reference, estimate;  ///< Files.
  std::string frames;               ///< Body of the poses, as text; set by the caller.
  PosePairing pairing;
  TrajectoryAlignment alignment = TrajectoryAlignment::none;
  bool alignment_unique = true;  ///< False: the positions lie on a line, so the rotation about it is undetermined.
  Sim3 reference_from_estimate;  ///< The alignment.
  double reference_path_m = 0.0, estimate_path_m = 0.0;  ///< Through the matched poses.
  std::optional<ErrorStatistics> ate_m;
  std::vector<RpeScores> rpe;           ///< One per requested delta.
  std::vector<SegmentErrors> segments;  ///< One per requested length.
  int segment_count = 0;
  std::optional<double> t_rel_percent, r_rel_deg_per_m;  ///< Means over all segments of all lengths.
  /// Error of the motion from the first to the last matched pose divided by the reference's path length.
  std::optional<double> drift_percent, drift_deg_per_m;
  PoseConsistency consistency;  ///< Set by the caller, for a run that gives covariances.

  /// Meters of the reference per unit of the estimate; 1 unless sim3.
  double scale() const { return reference_from_estimate.scale(); }

  std::vector<PosePair> pairs;
  std::vector<StampedPose> aligned;  ///< The estimate's poses of the pairs, in the reference's world.
};

/// Associates the poses (by stamp; by line if both are KITTI files of one length or without stamps), aligns and scores.
/// Throws Error if the sides cannot be associated, no pose is matched, or there is no alignment (a similarity of an
/// estimate at rest).
TrajectoryScores score_trajectory(const TrajectoryInput& reference, const TrajectoryInput& estimate,
                                  const TrajectoryScoreOptions& options);

}  // namespace rastro
