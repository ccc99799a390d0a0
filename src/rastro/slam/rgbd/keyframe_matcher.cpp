// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rgbd/keyframe_matcher.h"

#include <Eigen/LU>
#include <algorithm>

#include "rastro/feature/descriptor_matching.h"

namespace rastro {
namespace {

/// Size of the finest features; those found on coarser pictures are placed worse in proportion.
float finest_size(const DescribedKeypoints& features) {
  float finest = std::numeric_limits<float>::infinity();
  for (const Keypoint& keypoint : features.keypoints) finest = std::min(finest, keypoint.size_px);
  return finest;
}

double pixel_sigma(const Keypoint& keypoint, float finest, double sigma) {
  constexpr float most = 4.0F;
  const float scale = finest > 0.0F ? keypoint.size_px / finest : 1.0F;
  return sigma * static_cast<double>(std::clamp(scale, 1.0F, most));
}

}  // namespace

DepthNoise depth_noise(const RgbdSlamOptions& options) {
  return {options.follow.depth_sigma_m, options.follow.depth_sigma_per_m2};
}

KeyframeMatcher::KeyframeMatcher(const RgbdSlamOptions& options, const Camera& camera)
    : options_(options), camera_(camera), check_(camera, depth_noise(options)) {}

std::vector<PointTie> KeyframeMatcher::ties_of(const RgbdKeyframe& a, const RgbdKeyframe& b) const {
  DescriptorMatchOptions matching;
  matching.max_ratio = options_.max_ratio;
  const float finest_a = finest_size(a.features), finest_b = finest_size(b.features);
  std::vector<PointTie> ties;
  for (const DescriptorMatch& match : match_descriptors(b.features, a.features, matching)) {
    const Keypoint &in_a = a.features.keypoints[match.second], &in_b = b.features.keypoints[match.first];
    const auto ray_a = camera_.unproject(Eigen::Vector2d(Eigen::Vector2f(in_a.x, in_a.y).cast<double>()));
    const auto ray_b = camera_.unproject(Eigen::Vector2d(Eigen::Vector2f(in_b.x, in_b.y).cast<double>()));
    const auto depth_a = static_cast<double>(a.depths[match.second]),
               depth_b = static_cast<double>(b.depths[match.first]);
    if (!ray_a || !ray_b || (depth_a <= 0.0 && depth_b <= 0.0)) continue;
    ties.push_back({*ray_a, *ray_b, depth_a, depth_b, pixel_sigma(in_a, finest_a, options_.pixel_sigma),
                    pixel_sigma(in_b, finest_b, options_.pixel_sigma)});
  }
  return ties;
}

std::optional<KeyframeTie> KeyframeMatcher::match(const ViewOfKeyframe& a, const ViewOfKeyframe& b, int min_inliers,
                                                  std::uint64_t seed, const std::optional<SE3>& guess) const {
  const std::vector<PointTie> ties = ties_of(*a.keyframe, *b.keyframe);
  PointTieOptions fitting;
  fitting.noise = depth_noise(options_);
  fitting.focal_px = camera_.fx;
  fitting.iterations = options_.ransac_iterations;
  fitting.min_inliers = min_inliers;
  fitting.seed = seed;
  const std::optional<TiedViews> views = estimate_views(ties, fitting, guess);
  if (!views || views->inliers < options_.min_inlier_share * static_cast<double>(ties.size())) return std::nullopt;
  KeyframeTie tie{views->a_from_b, Matrix6d::Identity(), static_cast<int>(ties.size()), views->inliers, {}};
  const auto depth_a = a.depth(), depth_b = b.depth();
  if (depth_a && depth_b) {
    tie.agreement = check_.compare(*depth_a, *depth_b, tie.a_from_b);
    if (tie.agreement.share() < options_.agreement || tie.agreement.overlap() < options_.agreement_overlap)
      return std::nullopt;
  }
  // What pixels and depths have wrong in common, as by lens and clocks, does not go down with their number.
  Matrix6d covariance = views->information.inverse();
  covariance.diagonal().head<3>().array() += options_.edge_sigma_m * options_.edge_sigma_m;
  covariance.diagonal().tail<3>().array() += options_.edge_sigma_rad * options_.edge_sigma_rad;
  tie.information = covariance.inverse();
  tie.information = (0.5 * (tie.information + tie.information.transpose())).eval();
  return tie;
}

}  // namespace rastro
