// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Cholesky>

#include "rastro/slam/orb/tracking/frame_tracker.h"

namespace rastro {

/// Seen by several keyframes where it is now: it stands still.
bool FrameTracker::is_established(const TrackedPoint& point) const {
  constexpr std::uint32_t least_keyframes = 3;
  const std::int64_t found = view_->find(point.landmark);
  if (found < 0) return false;
  const auto at = static_cast<std::size_t>(found);
  return view_->seen_begin[at + 1] - view_->seen_begin[at] >= least_keyframes;
}

/// What moves gives landmarks too, new ones: where they and the established ones contradict each other, the pose is
/// that by the established ones. nullopt: they agree, or those are too few or too inconsistent to tell.
std::optional<PoseRefinement> FrameTracker::refine_by_established(const FeatureFrame& frame, const Search& search,
                                                                  const std::vector<FeatureMatch>& matches,
                                                                  const PoseRefinement& by_all) const {
  std::vector<FeatureMatch> established;
  for (const FeatureMatch& match : matches)
    if (is_established(search.points[match.subject])) established.push_back(match);
  if (static_cast<int>(established.size()) < options_.established_inliers) return std::nullopt;
  const PoseRefinement by_these = refine(frame, search, established, by_all.camera_from_world);
  if (by_these.inliers < options_.established_inliers ||
      by_these.inliers < options_.established_share * static_cast<double>(established.size()))
    return std::nullopt;
  const SE3 between = by_these.camera_from_world * by_all.camera_from_world.inverse();
  Vector6d moved;
  moved << between.translation(), between.rotation().log();
  if (!(moved.dot(by_these.covariance.ldlt().solve(moved)) > options_.established_contradiction)) return std::nullopt;
  PoseRefinement result = refine(frame, search, matches, by_these.camera_from_world, true);
  return result.inliers >= by_these.inliers / 2 ? std::optional(std::move(result)) : std::nullopt;
}

}  // namespace rastro
