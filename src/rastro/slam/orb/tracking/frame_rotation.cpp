// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/frame_rotation.h"

#include <utility>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/feature/descriptor_matching.h"
#include "rastro/multiview/rotation.h"

namespace rastro {

FrameRotation::FrameRotation(const Camera& camera, std::uint64_t seed, TaskPool* pool)
    : camera_(camera), seed_(seed), pool_(pool) {}

std::optional<Eigen::Vector3d> FrameRotation::next(const std::shared_ptr<const ImageFeatures>& frame) {
  constexpr int min_inliers = 30;
  const auto last = std::exchange(last_, frame);
  if (!last || frame->stamp <= last->stamp) return std::nullopt;
  std::vector<Eigen::Vector2d> before, now;
  for (const DescriptorMatch& match : match_descriptors(last->features, frame->features, {.max_distance = 50}, pool_)) {
    const Keypoint &a = last->features.keypoints[match.first], &b = frame->features.keypoints[match.second];
    const auto from = camera_.unproject({a.x, a.y}), to = camera_.unproject({b.x, b.y});
    if (!from || !to) continue;
    before.push_back(*from);
    now.push_back(*to);
  }
  CalibratedRansacOptions options;
  options.focal_px = camera_.fx;
  options.max_error_px = 6.0;  // The parallax of near points within a frame interval.
  options.seed = seed_;
  const auto fit = rotation_between(before, now, options);
  if (!fit || fit->inliers < min_inliers) return std::nullopt;
  return Eigen::Vector3d(fit->second_from_first.log() / to_seconds(frame->stamp - last->stamp));
}

}  // namespace rastro
