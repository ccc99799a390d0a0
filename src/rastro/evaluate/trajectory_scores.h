// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rastro/evaluate/trajectory_errors.h"
#include "rastro/evaluate/trajectory_input.h"
#include "rastro/evaluate/trajectory_pairs.h"
#include "rastro/math/sim3.h"

namespace rastro {

/// How the estimate is brought to the reference before it is compared, over all matched positions (math/alignment.h).
enum class TrajectoryAlignment : std::uint8_t {
  none,
  se3,   ///< Turned and moved.
  sim3,  ///< Scaled too: for one camera, which cannot know its scale.
  yaw,   ///< Turned about the reference's z axis and moved: for systems that know gravity.
};
const char* name_of(TrajectoryAlignment alignment);
/// Error for any other name.
TrajectoryAlignment parse_alignment(const std::string& name);

struct TrajectoryScoreOptions {
  TrajectoryAlignment alignment = TrajectoryAlignment::se3;
  TimeNs max_difference = 20'000'000;  ///< Stamps farther apart are not matched.
  std::vector<double> segments_m = {100, 200, 300, 400, 500, 600, 700, 800};
  std::vector<RpeDelta> rpe_deltas = {
      {1.0, RpeDelta::Unit::frames}, {1.0, RpeDelta::Unit::seconds}, {1.0, RpeDelta::Unit::metres}};
  bool rpe_all_pairs = false;
};

struct RpeScores {
  RpeDelta delta;
  std::optional<ErrorStatistics> translation_m;
  std::optional<ErrorStatistics> rotation_deg;
};

/// What is known of an estimate against a reference. Everything but `scale` and `target_from_estimate` is measured
/// after the alignment; relative errors and segments feel nothing of it but the scale.
struct TrajectoryScores {
  std::string reference, estimate;  ///< Files.
  std::string frames;               ///< What the poses are of, for people; left to who read them.
  int reference_poses = 0, estimate_poses = 0, matched = 0;
  bool by_index = false;              ///< Paired by line, since neither or only one side has stamps.
  double largest_difference_s = 0.0;  ///< Of the stamps of a pair.
  double coverage_percent = 0.0;      ///< See coverage_of().
  TrajectoryAlignment alignment = TrajectoryAlignment::none;
  double scale = 1.0;            ///< Metres of the reference per unit of the estimate; 1 unless sim3.
  bool alignment_unique = true;  ///< False: the positions lie on a line and leave a turn about it open.
  Sim3 reference_from_estimate;  ///< The alignment.
  double reference_path_m = 0.0, estimate_path_m = 0.0;  ///< Through the matched poses.
  std::optional<ErrorStatistics> ate_m;
  std::vector<RpeScores> rpe;           ///< One for each delta asked for.
  std::vector<SegmentErrors> segments;  ///< One for each length asked for.
  int segment_count = 0;
  std::optional<double> t_rel_percent, r_rel_deg_per_m;  ///< Means over all segments of all lengths.
  /// Error of the motion from the first to the last matched pose per path of the reference.
  std::optional<double> drift_percent, drift_deg_per_m;

  std::vector<PosePair> pairs;
  std::vector<StampedPose> aligned;  ///< The estimate's poses of the pairs, in the reference's world.
};

/// Pairs the poses (by stamp; by line where the files have none, or both are KITTI files), aligns and measures. Error
/// where the sides cannot be paired, no pose is matched, or no alignment exists (a similarity of an estimate that
/// stands still).
TrajectoryScores score_trajectory(const TrajectoryInput& reference, const TrajectoryInput& estimate,
                                  const TrajectoryScoreOptions& options);

}  // namespace rastro
