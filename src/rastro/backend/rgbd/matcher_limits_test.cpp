// SPDX-License-Identifier: Apache-2.0
// What the matcher of keyframes asks of surfaces, with few features and with enough, and how sure it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "rastro/backend/rgbd/keyframe_matcher.h"
#include "rastro/backend/rgbd/rgbd_testing.h"

namespace rastro {
namespace {

using testing::looking;
using testing::room_frame;
using testing::room_keyframe;
using testing::with_depth_noise;

/// Two views into a corner of the room, the second with all or few of its features. The second measured a part of the
/// wall that nothing has a feature of too near.
struct CornerPair {
  explicit CornerPair(std::size_t kept) {
    const SE3 pose_a = looking({-0.8, -0.4, 1.2}, M_PI + 0.7, -0.4),
              pose_b = looking({-0.85, -0.3, 1.25}, M_PI + 0.65, -0.4);
    const Frame frame_a = with_depth_noise(room_frame(pose_a), options, 1);
    Frame frame_b = with_depth_noise(room_frame(pose_b), options, 2);
    a = room_keyframe(frame_a, 0, options);
    auto fewer = std::make_shared<ImageFeatures>(*room_keyframe(frame_b, 0, options));
    fewer->features.keypoints.resize(std::min(kept, fewer->features.size()));
    fewer->features.descriptors.resize(fewer->features.keypoints.size());
    fewer->depths.resize(fewer->features.keypoints.size());
    b = fewer;
    for (int y = 100; y < 140; ++y)
      for (int x = 140; x < 170; ++x) frame_b.depth.at(x, y) -= 0.4F;
    const KeyframeMatcher matcher(options, test_room::camera());
    surface_a = std::make_shared<const KeyframeSurface>(matcher.surfaces().surface_of(frame_a.depth));
    surface_b = std::make_shared<const KeyframeSurface>(matcher.surfaces().surface_of(frame_b.depth));
  }
  std::optional<KeyframeConstraint> match(int min_inliers = 25) const {
    return KeyframeMatcher(options, test_room::camera())
        .match({a.get(), [&] { return surface_a; }}, {b.get(), [&] { return surface_b; }}, {min_inliers});
  }

  RgbdSlamOptions options;
  std::shared_ptr<const ImageFeatures> a, b;
  std::shared_ptr<const KeyframeSurface> surface_a, surface_b;
};

constexpr std::size_t all_features = 100000, few_features_kept = 40;
constexpr double a_little = 1e-9;

TEST(MatcherLimits, WithEnoughFeaturesSurfacesMustOverlapAndAgreeAsTheOptionsSay) {
  CornerPair pair(all_features);
  pair.options.agreement = 0.0;
  const auto found = pair.match();
  ASSERT_TRUE(found);
  ASSERT_GE(found->inliers, 25);
  const double overlap = found->evidence().overlap(), share = found->evidence().observed_share();
  ASSERT_LT(share, 1.0);
  pair.options.agreement_overlap = overlap - a_little;
  EXPECT_TRUE(pair.match());
  pair.options.agreement_overlap = overlap + a_little;
  EXPECT_FALSE(pair.match());
  pair.options.agreement_overlap = 0.0;
  pair.options.agreement = share - a_little;
  EXPECT_TRUE(pair.match());
  pair.options.agreement = share + a_little;
  EXPECT_FALSE(pair.match());
}

TEST(MatcherLimits, WithFewFeaturesTheyMustOverlapThriceAndAgreeHalfwayToAll) {
  CornerPair pair(few_features_kept);
  pair.options.agreement = 0.0;
  const auto found = pair.match();
  ASSERT_TRUE(found);
  ASSERT_LT(found->inliers, 25);
  const double overlap = found->evidence().overlap(), share = found->evidence().observed_share();
  ASSERT_LT(share, 1.0);
  ASSERT_GT(share, 0.5);
  pair.options.agreement_overlap = overlap / 3.0 - a_little;
  EXPECT_TRUE(pair.match());
  pair.options.agreement_overlap = overlap / 3.0 + a_little;
  EXPECT_FALSE(pair.match());
  pair.options.agreement_overlap = 0.0;
  pair.options.agreement = 2.0 * share - 1.0 - a_little;
  EXPECT_TRUE(pair.match());
  pair.options.agreement = 2.0 * share - 1.0 + a_little;
  EXPECT_FALSE(pair.match());
}

TEST(MatcherLimits, FeaturesAreFewBelowTheNumberAskedForAndTooFewBelowTheOption) {
  CornerPair pair(few_features_kept);
  const auto by_surfaces = pair.match(25);
  ASSERT_TRUE(by_surfaces);
  const int inliers = by_surfaces->inliers;
  const auto by_features = pair.match(inliers);
  ASSERT_TRUE(by_features);
  EXPECT_EQ(by_features->inliers, inliers);
  EXPECT_GT((by_features->a_from_b.inverse() * by_surfaces->a_from_b).log().norm(), 1e-5);
  EXPECT_EQ(pair.match(inliers + 1)->a_from_b.matrix(), by_surfaces->a_from_b.matrix());
  pair.options.few_inliers = inliers;
  EXPECT_TRUE(pair.match(25));
  pair.options.few_inliers = inliers + 1;
  EXPECT_FALSE(pair.match(25));
}

/// Depths of neighboring blocks have errors in common, so that each counts a twentieth.
TEST(MatcherLimits, SurfacesAreAsSureAsATwentiethOfTheirBlocks) {
  CornerPair pair(few_features_kept);
  const auto found = pair.match();
  ASSERT_TRUE(found);
  const KeyframeMatcher matcher(pair.options, test_room::camera());
  const SurfaceFit fit = matcher.surfaces().fit(*pair.surface_a, *pair.surface_b, found->a_from_b, 0.05);
  Matrix6d covariance = match_covariance_factor * (0.05 * fit.information).inverse();
  for (int i = 0; i < 6; ++i)
    covariance(i, i) += std::pow(i < 3 ? pair.options.edge_sigma_m : pair.options.edge_sigma_rad, 2);
  const Matrix6d expected = covariance.inverse();
  EXPECT_LT((found->information - expected).norm(), 0.02 * expected.norm());
}

}  // namespace
}  // namespace rastro
