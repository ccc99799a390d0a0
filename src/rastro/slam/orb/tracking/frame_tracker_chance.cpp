// SPDX-License-Identifier: Apache-2.0
// FrameTracker: how many landmarks fit a pose by chance.
#include "rastro/slam/orb/map/landmark_search.h"
#include "rastro/slam/orb/tracking/frame_tracker.h"

namespace rastro {

double FrameTracker::chance_inliers(const FeatureFrame& frame, const SE3& camera_from_world) const {
  const auto rotations = rotations_beyond_windows(options_.local_search_px * level_scales_.back(), camera_);
  double sum = 0.0;
  for (const SO3& rotation : rotations)
    sum += track_local_map(frame, SE3(rotation, Eigen::Vector3d::Zero()) * camera_from_world).inliers;
  return sum / static_cast<double>(rotations.size());
}

/// The share changes slowly with the scene, so it is estimated anew only where it might decide.
bool FrameTracker::exceeds_chance(const FeatureFrame& frame, TrackingResult& result) {
  const auto visible = static_cast<double>(result.visible.size());
  const auto needed = [&](double by_chance) { return options_.min_chance_ratio * (by_chance + 1.0); };
  if (result.inliers >= 2.0 * needed(chance_share_ * visible)) return true;
  result.chance_inliers = chance_inliers(frame, result.camera_from_world);
  if (visible > 0.0) chance_share_ = result.chance_inliers / visible;
  return result.inliers >= needed(result.chance_inliers);
}

}  // namespace rastro
