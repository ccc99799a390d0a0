// SPDX-License-Identifier: Apache-2.0
// FrameTracker: how many landmarks fit a pose by chance.
#include <array>

#include "rastro/slam/orb/tracking/frame_tracker.h"

namespace rastro {

double FrameTracker::chance_inliers(const FeatureFrame& frame, const SE3& camera_from_world) const {
  // Beyond the largest search window, so that no landmark can be matched to itself.
  const double largest_window_px = options_.local_search_px * level_scales_.back();
  const double angle_rad = 3.0 * largest_window_px / camera_.fx;
  constexpr std::array shares{-1.0, -0.7, 0.7, 1.0};
  double sum = 0.0;
  for (const Eigen::Vector3d& axis : {Eigen::Vector3d::UnitX().eval(), Eigen::Vector3d::UnitY().eval()}) {
    for (const double share : shares) {
      const SE3 rotated(SO3::exp(share * angle_rad * axis), Eigen::Vector3d::Zero());
      sum += track_local_map(frame, rotated * camera_from_world).inliers;
    }
  }
  return sum / (2.0 * shares.size());
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
