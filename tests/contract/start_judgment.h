// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/map/features/feature_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/slam/slam_method.h"
#include "rastro/synthetic/worlds/starts.h"

namespace rastro {

/// Initialization of a map of one camera, and whether it is correct up to scale.
struct StartJudgment {
  std::optional<std::int64_t> started;  ///< The first frame that was tracked, nullopt: none.
  std::string waiting;                  ///< What it last waited for.
  std::size_t poses = 0, landmarks = 0;
  double path_m = 0.0;              ///< Of the camera, from the first frame with a pose on.
  double position_error = 0.0;      ///< Root mean square, as a share of the path length, after scaling.
  double rotation_error_rad = 0.0;  ///< The largest.
  double depth_error = 0.0;         ///< Median of the landmarks, as a share of the true depth.

  /// The map was initialized correctly.
  bool right() const {
    return started && landmarks >= 50 && position_error < 0.08 && rotation_error_rad < 0.05 && depth_error < 0.10;
  }
  /// No map, or a correct one.
  bool never_wrong() const { return !started || right(); }
};

namespace start_detail {

inline double scale_between(const std::vector<Eigen::Vector3d>& ground_truth,
                            const std::vector<Eigen::Vector3d>& estimate) {
  double both = 0.0, own = 0.0;
  for (std::size_t i = 0; i < ground_truth.size(); ++i)
    both += ground_truth[i].dot(estimate[i]), own += estimate[i].squaredNorm();
  return own > 0.0 ? both / own : 0.0;
}

/// Frame of a stamp; the world's stamps are evenly spaced.
inline std::int64_t frame_at(const World& world, TimeNs stamp) {
  const double seconds = static_cast<double>(stamp - world.stamp(0)) * 1e-9;
  return std::llround(seconds * world.rate_hz());
}

inline void judge_path(const World& world, const Trajectory& trajectory, StartJudgment& judgment, double& scale) {
  std::vector<Eigen::Vector3d> ground_truth, estimate;
  const SE3 true_first = world.world_from_camera(frame_at(world, trajectory.front().stamp));
  for (const StampedPose& pose : trajectory) {
    const SE3 moved = true_first.inverse() * world.world_from_camera(frame_at(world, pose.stamp));
    const SE3 followed = trajectory.front().world_from_body.inverse() * pose.world_from_body;
    ground_truth.push_back(moved.translation());
    estimate.push_back(followed.translation());
    judgment.rotation_error_rad =
        std::max(judgment.rotation_error_rad, (moved.rotation().inverse() * followed.rotation()).log().norm());
  }
  scale = scale_between(ground_truth, estimate);
  double squares = 0.0;
  for (std::size_t i = 0; i < ground_truth.size(); ++i) {
    squares += (scale * estimate[i] - ground_truth[i]).squaredNorm();
    if (i > 0) judgment.path_m += (ground_truth[i] - ground_truth[i - 1]).norm();
  }
  judgment.position_error =
      std::sqrt(squares / static_cast<double>(ground_truth.size())) / std::max(1e-9, judgment.path_m);
}

/// Each landmark is compared with the surface at its feature in its first keyframe.
inline void judge_landmarks(const World& world, const Map& map, double scale, StartJudgment& judgment) {
  const auto landmarks = map.layer<LandmarkLayer>();
  const auto features = map.layer<FeatureLayer>();
  if (!landmarks || !features) return;
  std::vector<double> errors;
  for (const Landmark& landmark : landmarks->landmarks) {
    if (landmark.observations.empty()) continue;
    const LandmarkObservation& seen = landmark.observations.front();
    const Keyframe* keyframe = map.find(seen.keyframe);
    const ImageFeatures* image = keyframe ? features->find(keyframe->id) : nullptr;
    if (!image) continue;
    const Keypoint& at = image->features.keypoints[seen.feature];
    const auto hit = world.surface_at(frame_at(world, keyframe->stamp), {at.x, at.y});
    const double depth = scale * (keyframe->world_from_camera.inverse() * landmark.position).z();
    errors.push_back(hit ? std::abs(depth / hit->t - 1.0) : 1.0);
  }
  judgment.landmarks = errors.size();
  if (errors.empty()) return;
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  judgment.depth_error = errors[errors.size() / 2];
}

}  // namespace start_detail

/// Runs a method over the first frames of a world with one camera and compares its map with the world.
inline StartJudgment judge_start(const World& world, const SlamMethod& method, TaskPool& pool,
                                 std::int64_t frames = start_frames) {
  const auto source = synthetic_source(world, frames, 1);
  const auto slam = method.make(source->info(), {.pool = &pool});
  StartJudgment judgment;
  while (auto frame = source->next()) {
    frame->depth = {};
    const SlamUpdate update = slam->process(*frame);
    if (update.state == SlamState::initializing) judgment.waiting = update.detail;
    if (!judgment.started && update.state == SlamState::tracking) judgment.started = frame->index;
  }
  slam->finish();
  const Trajectory trajectory = slam->trajectory();
  judgment.poses = trajectory.size();
  if (!judgment.started || trajectory.size() < 2) return judgment;
  double scale = 0.0;
  start_detail::judge_path(world, trajectory, judgment, scale);
  if (const auto map = slam->snapshot()) start_detail::judge_landmarks(world, *map, scale, judgment);
  return judgment;
}

}  // namespace rastro
