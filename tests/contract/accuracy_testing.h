// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "place_testing.h"
#include "rastro/math/alignment.h"

namespace rastro {

/// Maximum error of a method in its recording, and how many frames must have a pose.
struct AccuracyLimit {
  double worst_m = 0.0;      ///< Of any pose: about one and a half times what was measured.
  double least_poses = 1.0;  ///< Share of the frames.
};

/// By method and sensor. CheapGuessesFailItsLimit checks that trivial guesses fail each limit.
inline AccuracyLimit accuracy_limit(const std::string& method) {
  static const std::map<std::string, AccuracyLimit> limits = {
      {"ekf", {0.014, 1.0}},            // measured: 0.0091
      {"fusion", {0.021, 1.0}},         // 0.0139, after a black second; else 0.0087
      {"fusion_stereo", {0.027, 1.0}},  // 0.0181
      {"hector", {0.055, 1.0}},         // 0.0363, without odometry
      {"lsd", {0.007, 1.0}},            // 0.0046
      {"lsd_mono", {0.0125, 1.0}},      // 0.0081
      {"lsd_stereo", {0.041, 1.0}},     // 0.0272
      {"orb", {0.035, 1.0}},            // 0.0235, after a spoilt frame; else 0.0220
      {"orb_mono", {0.035, 1.0}},       // 0.0152
      {"orb_stereo", {0.057, 1.0}},     // 0.0379
      {"rgbd", {0.018, 1.0}},           // 0.0118, after a spoilt frame; else 0.0054
      {"rtabmap", {0.018, 1.0}},        // the same tracking
      {"rtabmap_stereo", {0.09, 1.0}},  // 0.0600
  };
  const auto found = limits.find(method);
  // A new method has to be measured first; until then it fails.
  return found == limits.end() ? AccuracyLimit{0.0, 1.0} : found->second;
}

/// Frames [first, end) of a recording.
struct FrameRange {
  int first = 0, end = std::numeric_limits<int>::max();
};

/// Number of the frame with this very stamp; nullopt where there is none.
inline std::optional<int> frame_of(const TestRecording& recording, TimeNs stamp) {
  const TimeNs since = stamp - recording.stamp(0);
  const auto k = static_cast<int>((since + recording.step() / 2) / recording.step());
  return since >= 0 && recording.stamp(k) == stamp ? std::optional<int>(k) : std::nullopt;
}

/// True and estimated positions of the poses in `range`, by their stamps. A pose whose stamp is of no
/// frame is skipped.
struct PairedPositions {
  std::vector<Eigen::Vector3d> ground_truth, estimate;
};

inline PairedPositions paired_positions(const Trajectory& trajectory, const TestRecording& recording,
                                        FrameRange range = {}) {
  PairedPositions paired;
  for (const StampedPose& pose : trajectory) {
    const std::optional<int> k = frame_of(recording, pose.stamp);
    if (!k || *k < range.first || *k >= range.end) continue;
    paired.ground_truth.push_back(recording.world_from_body(*k).translation());
    paired.estimate.push_back(pose.world_from_body.translation());
  }
  return paired;
}

/// Maximum position error of the poses in `range`: aligned by the first pose of the trajectory where it is metric, else
/// by similarity. Infinite without a pose.
inline double worst_error_m(const Trajectory& trajectory, const TestRecording& recording, FrameRange range = {}) {
  const PairedPositions paired = paired_positions(trajectory, recording, range);
  if (paired.ground_truth.empty()) return std::numeric_limits<double>::infinity();
  Sim3 ground_truth_from_estimate;
  if (recording.is_metric()) {
    const auto first = std::find_if(trajectory.begin(), trajectory.end(), [&](const StampedPose& pose) {
      return frame_of(recording, pose.stamp).has_value();
    });
    const SE3 ground_truth_from =
        recording.world_from_body(*frame_of(recording, first->stamp)) * first->world_from_body.inverse();
    ground_truth_from_estimate = Sim3(1.0, ground_truth_from.rotation(), ground_truth_from.translation());
  } else {
    const auto aligned = align_points(paired.ground_truth, paired.estimate, AlignmentKind::similarity);
    if (!aligned) return std::numeric_limits<double>::infinity();
    ground_truth_from_estimate = aligned->target_from_source;
  }
  double worst = 0.0;
  for (std::size_t i = 0; i < paired.ground_truth.size(); ++i)
    worst = std::max(worst, (ground_truth_from_estimate * paired.estimate[i] - paired.ground_truth[i]).norm());
  return worst;
}

/// Trivial trajectories, which must fail the limits.
struct CheapGuess {
  const char* what;
  Trajectory trajectory;
};

inline std::vector<CheapGuess> cheap_guesses(const TestRecording& recording) {
  std::vector<CheapGuess> guesses = {{"it never moved", {}}, {"it goes on as it began", {}}};
  const SE3 start = recording.world_from_body(0);
  SE3 going = start;
  const SE3 motion = start.inverse() * recording.world_from_body(1);
  for (int k = 0; k < recording.frame_count(); ++k) {
    guesses[0].trajectory.push_back({recording.stamp(k), start});
    guesses[1].trajectory.push_back({recording.stamp(k), going});
    going = going * motion;
  }
  if (!recording.is_metric()) {
    // Without any motion: alignment and scale are undefined.
    guesses.erase(guesses.begin());
    return guesses;
  }
  for (const double scale : {0.9, 1.1}) {
    guesses.push_back({scale < 1.0 ? "a tenth too short" : "a tenth too long", {}});
    for (int k = 0; k < recording.frame_count(); ++k) {
      const SE3 pose = start.inverse() * recording.world_from_body(k);
      guesses.back().trajectory.push_back({recording.stamp(k), {pose.rotation(), scale * pose.translation()}});
    }
  }
  if (!recording.info().has_odometry) return guesses;
  guesses.push_back({"its wheels alone", {}});
  for (int k = 0; k < recording.frame_count(); ++k) {
    const SE2 pose = *recording.frame(k).odometry_from_body;
    guesses.back().trajectory.push_back({recording.stamp(k),
                                         {SO3::exp(pose.rotation().angle() * Eigen::Vector3d::UnitZ()),
                                          {pose.translation().x(), pose.translation().y(), 0.0}}});
  }
  return guesses;
}

}  // namespace rastro
