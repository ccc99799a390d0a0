// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/keyframe_matcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include <cstring>
#include <limits>

#include "rastro/backend/rgbd/rgbd_testing.h"

namespace rastro {
namespace {

using testing::looking;
using testing::pose_near;
using testing::room_frame;
using testing::room_keyframe;
using testing::unknown_frame;
using testing::with_depth_noise;

/// A view of the room, its keyframe and its surface.
struct View {
  SE3 world_from_camera;
  std::shared_ptr<const ImageFeatures> keyframe;
  std::shared_ptr<const KeyframeSurface> surface;
};

class KeyframeMatcherTest : public ::testing::Test {
 protected:
  View view(const SE3& pose, std::uint64_t noise_seed) const {
    return view_of(with_depth_noise(room_frame(pose), options_, noise_seed), pose);
  }
  View view_of(const Frame& frame, const SE3& pose = SE3()) const {
    const KeyframeMatcher matcher(options_, test_room::camera());
    return {pose, room_keyframe(frame, 0, options_),
            std::make_shared<const KeyframeSurface>(matcher.surfaces().surface_of(frame.depth))};
  }
  std::optional<KeyframeConstraint> match(const View& a, const View& b, int min_inliers = 25, std::uint64_t seed = 1,
                                          const std::optional<SE3>& guess = std::nullopt,
                                          MatchScope scope = MatchScope::anywhere) const {
    return KeyframeMatcher(options_, test_room::camera())
        .match({a.keyframe.get(), [&] { return a.surface; }}, {b.keyframe.get(), [&] { return b.surface; }},
               {min_inliers, seed, guess, scope});
  }

  RgbdSlamOptions options_;
  SE3 pose_a_ = looking({-1.2, -0.2, 1.2}, 0.1), pose_b_ = looking({-1.1, 0.05, 1.25}, 0.0);
};

TEST_F(KeyframeMatcherTest, FindsTheMotionBetweenTwoViewsWithinItsSigmas) {
  double sum = 0.0;
  constexpr int pairs = 8;
  for (int k = 0; k < pairs; ++k) {
    const SE3 moved = pose_b_ * SE3(SO3::exp({0.0, 0.02 * k - 0.08, 0.01 * k}), {0.02 * k, 0.0, 0.0});
    const View a = view(pose_a_, static_cast<std::uint64_t>(2 * k)),
               b = view(moved, static_cast<std::uint64_t>(2 * k + 1));
    const auto constraint = match(a, b);
    ASSERT_TRUE(constraint) << k;
    EXPECT_GE(constraint->inliers, 25);
    EXPECT_LE(constraint->inliers, constraint->matches);
    const SE3 ground_truth = a.world_from_camera.inverse() * b.world_from_camera;
    EXPECT_THAT(constraint->a_from_b, pose_near(ground_truth, 0.025, 0.008)) << k;
    const Vector6d error = (constraint->a_from_b.inverse() * ground_truth).log();
    sum += error.dot(constraint->information * error);
    EXPECT_GT(constraint->agreement.evidence().observed_share(), 0.95);
    EXPECT_EQ(constraint->information, constraint->information.transpose());
  }
  EXPECT_LT(sum / pairs, 12.0) << "6 on average for a right covariance";
}

TEST_F(KeyframeMatcherTest, HasAMinimumSigma) {
  options_.edge_sigma_m = 0.05;
  options_.edge_sigma_rad = 0.03;
  const auto constraint = match(view(pose_a_, 1), view(pose_b_, 2));
  ASSERT_TRUE(constraint);
  const Matrix6d covariance = constraint->information.inverse();
  for (int i = 0; i < 6; ++i) {
    const double floor = i < 3 ? 0.05 : 0.03;
    EXPECT_GT(covariance(i, i), floor * floor);
    EXPECT_LT(covariance(i, i), 2.0 * floor * floor) << "many matches add little to it";
  }
}

TEST_F(KeyframeMatcherTest, TheSameSeedGivesTheSameBytes) {
  const View a = view(pose_a_, 1), b = view(pose_b_, 2);
  const auto once = match(a, b, 25, 9), again = match(a, b, 25, 9);
  ASSERT_TRUE(once && again);
  EXPECT_EQ(once->a_from_b.matrix(), again->a_from_b.matrix());
  EXPECT_EQ(once->information, again->information);
  EXPECT_EQ(once->inliers, again->inliers);
}

TEST_F(KeyframeMatcherTest, ViewsOfDifferentWallsHaveNothingInCommon) {
  const View ahead = view(looking({0.0, -0.5, 1.2}, 0.0), 1), behind = view(looking({0.0, -0.5, 1.2}, M_PI), 2);
  EXPECT_FALSE(match(ahead, behind));
  EXPECT_FALSE(match(ahead, view_of(unknown_frame(5))));
}

TEST_F(KeyframeMatcherTest, FewerInliersThanAskedForAreRefused) {
  options_.few_features = "refuse";
  const View a = view(pose_a_, 1), b = view(pose_b_, 2);
  const auto constraint = match(a, b);
  ASSERT_TRUE(constraint);
  EXPECT_TRUE(match(a, b, constraint->inliers - 5));
  EXPECT_FALSE(match(a, b, constraint->inliers + 20));
}

/// Most of the image moves along the wall by itself, as a crowd does.
TEST_F(KeyframeMatcherTest, WhereMostOfTheImageMovesOnlyTheGuessShowsWhatStandsStill) {
  const SE3 still = looking({-0.8, -0.4, 1.2}, 0.0, 0.0), moved = looking({-0.8, -0.28, 1.2}, 0.0, 0.0);
  Frame frame = room_frame(still);
  const Frame other = room_frame(moved);
  const int columns = 72 * frame.image.width() / 100;
  for (int y = 0; y < frame.image.height(); ++y) {
    std::copy_n(other.image.row(y), columns, frame.image.row(y));
    std::copy_n(other.depth.row(y), columns, frame.depth.row(y));
  }
  const View before = view_of(room_frame(still)), now = view_of(frame);
  const auto most = match(before, now);
  ASSERT_TRUE(most);
  EXPECT_THAT(most->a_from_b, pose_near(still.inverse() * moved, 0.02, 0.01));
  const auto near = match(before, now, 25, 1, SE3(), MatchScope::near_guess);
  ASSERT_TRUE(near);
  EXPECT_THAT(near->a_from_b, pose_near(SE3(), 0.02, 0.01));
  EXPECT_LT(near->inliers, most->inliers);
}

TEST_F(KeyframeMatcherTest, TooSmallAShareOfInliersIsRefused) {
  const View a = view(pose_a_, 1), b = view(pose_b_, 2);
  const auto constraint = match(a, b);
  ASSERT_TRUE(constraint);
  const double share = static_cast<double>(constraint->inliers) / constraint->matches;
  options_.min_inlier_share = share - 0.05;
  EXPECT_TRUE(match(a, b));
  options_.min_inlier_share = std::min(1.0, share + 0.05);
  EXPECT_FALSE(match(a, b));
}

/// Drops all but a few of the features.
View thinned(const View& view, std::size_t keep) {
  auto fewer = std::make_shared<ImageFeatures>(*view.keyframe);
  fewer->features.keypoints.resize(keep);
  fewer->features.descriptors.resize(keep);
  fewer->depths.resize(keep);
  return {view.world_from_camera, fewer, view.surface};
}

/// Into a corner, where three walls determine the pose.
TEST_F(KeyframeMatcherTest, SurfacesDecideWithFewFeatures) {
  const SE3 pose_a = looking({-0.8, -0.4, 1.2}, M_PI + 0.7, -0.4),
            pose_b = looking({-0.85, -0.3, 1.25}, M_PI + 0.65, -0.4);
  const View a = view(pose_a, 1), b = thinned(view(pose_b, 2), 40);
  const auto few = match(a, b, 25);
  ASSERT_TRUE(few);
  ASSERT_LT(few->inliers, 25) << "too few to decide alone";
  EXPECT_THAT(few->a_from_b, pose_near(pose_a.inverse() * pose_b, 0.0015, 0.001)) << "surfaces have it better";
  options_.few_features = "refuse";
  EXPECT_FALSE(match(a, b, 25));
}

/// Few features may be off by a hand's breadth, and surfaces have it better; but not those that are found elsewhere.
TEST_F(KeyframeMatcherTest, SurfacesThatSlideFarFromTheFeaturesDoNotDecide) {
  const SE3 pose_a = looking({-0.8, -0.4, 1.2}, M_PI + 0.7, -0.4),
            pose_b = looking({-0.85, -0.3, 1.25}, M_PI + 0.65, -0.4);
  const View a = view(pose_a, 1);
  View b = thinned(view(pose_b, 2), 40);
  for (const double turned_rad : {-0.5, -0.25, -0.15, 0.0, 0.15, 0.25, 0.5}) {
    const SE3 seen = pose_b * SE3(SO3::exp({0.0, 0.0, turned_rad}), Eigen::Vector3d::Zero());
    b.surface = view(seen, 3).surface;
    const auto slid = match(a, b, 25);
    ASSERT_EQ(slid.has_value(), std::abs(turned_rad) < 0.2) << turned_rad;
    if (!slid) continue;
    EXPECT_THAT(slid->a_from_b, pose_near(pose_a.inverse() * seen, 0.002, 0.002)) << turned_rad;
  }
}

/// Wall and floor do not constrain the direction along both.
TEST_F(KeyframeMatcherTest, SurfacesThatLeaveADirectionUnconstrainedDoNotDecide) {
  const View a = view(pose_a_, 1), b = thinned(view(pose_b_, 2), 80);
  const auto enough = match(a, b, 12);
  ASSERT_TRUE(enough) << "features alone may";
  ASSERT_LT(enough->inliers, 25);
  EXPECT_FALSE(match(a, b, 25));
}

TEST_F(KeyframeMatcherTest, AMatchThatDepthContradictsIsRefused) {
  const View a = view(pose_a_, 1), b = view(pose_b_, 2);
  ASSERT_TRUE(match(a, b));
  // The same features, but b measured surfaces 0.5 m nearer: they are in front of those that a measured.
  Frame nearer = room_frame(pose_b_);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) nearer.depth.at(x, y) -= 0.5F;
  View contradicted = b;
  contradicted.surface = view_of(nearer).surface;
  EXPECT_FALSE(match(a, contradicted));
  View blind = b;
  blind.surface = std::make_shared<const KeyframeSurface>();
  EXPECT_FALSE(match(a, blind)) << "nor is it believed where nothing could be judged";
}

TEST_F(KeyframeMatcherTest, MatchesHavePositionsAndSigmas) {
  const View a = view(pose_a_, 1), b = view(pose_b_, 2);
  const KeyframeMatcher matcher(options_, test_room::camera());
  const std::vector<PointMatch> matches = matcher.matches_of(*a.keyframe, *b.keyframe);
  ASSERT_GT(matches.size(), 50U);
  const SE3 a_from_b = pose_a_.inverse() * pose_b_;
  int close = 0;
  for (const PointMatch& point_match : matches) {
    EXPECT_TRUE(point_match.depth_a > 0.0 || point_match.depth_b > 0.0);
    EXPECT_GE(point_match.sigma_a, options_.pixel_sigma);
    EXPECT_LE(point_match.sigma_a, 2.0 * options_.pixel_sigma) << "of coarse features twice as much at most";
    if (point_match.depth_b <= 0.0) continue;
    const Eigen::Vector3d in_a = a_from_b * (point_match.depth_b * point_match.ray_b.homogeneous());
    close += (in_a.hnormalized() - point_match.ray_a).norm() * 260.0 < 4.0 ? 1 : 0;
  }
  EXPECT_GT(close, static_cast<int>(matches.size()) / 2) << "from b to a, not the other way";
}

/// A coarse feature's position is as uncertain as it is large, up to twice as much as that of the finest.
TEST_F(KeyframeMatcherTest, SigmasGrowWithTheSizeOfTheFeature) {
  options_.pixel_sigma = 1.5;
  const View a = view(pose_a_, 1), b = view(pose_b_, 2);
  const auto sigma_at = [&](const ImageFeatures& image, const Eigen::Vector2d& ray) {
    float finest = 1e9F, size = 0.0F;
    for (const Keypoint& keypoint : image.features.keypoints) {
      finest = std::min(finest, keypoint.size_px);
      const Eigen::Vector2d pixel(static_cast<double>(keypoint.x), static_cast<double>(keypoint.y));
      if ((260.0 * ray + Eigen::Vector2d(159.5, 119.5) - pixel).norm() < 1e-9) size = keypoint.size_px;
    }
    return 1.5 * std::min(2.0, static_cast<double>(size) / static_cast<double>(finest));
  };
  int coarse = 0, between = 0;
  for (const PointMatch& found : KeyframeMatcher(options_, test_room::camera()).matches_of(*a.keyframe, *b.keyframe)) {
    EXPECT_NEAR(found.sigma_a, sigma_at(*a.keyframe, found.ray_a), 1e-6);
    EXPECT_NEAR(found.sigma_b, sigma_at(*b.keyframe, found.ray_b), 1e-6);
    coarse += found.sigma_a > 2.99 ? 1 : 0;
    between += found.sigma_a > 1.51 && found.sigma_a < 2.99 ? 1 : 0;
  }
  EXPECT_GT(coarse, 3);
  EXPECT_GT(between, 3);
}

TEST_F(KeyframeMatcherTest, FeaturesWithoutDepthInBothAreNoMatches) {
  const View a = view(pose_a_, 1), b = view(pose_b_, 2);
  const KeyframeMatcher matcher(options_, test_room::camera());
  const auto without = [](const View& view) {
    auto keyframe = std::make_shared<ImageFeatures>(*view.keyframe);
    std::fill(keyframe->depths.begin(), keyframe->depths.end(), 0.0F);
    return keyframe;
  };
  const auto flat_a = without(a), flat_b = without(b);
  EXPECT_TRUE(matcher.matches_of(*flat_a, *flat_b).empty());
  const std::vector<PointMatch> by_b = matcher.matches_of(*flat_a, *b.keyframe);
  EXPECT_GT(by_b.size(), 30U) << "one depth of the two is enough";
  View half = a;
  half.keyframe = flat_a;
  const auto constraint = match(half, b);
  ASSERT_TRUE(constraint);
  EXPECT_THAT(constraint->a_from_b, pose_near(pose_a_.inverse() * pose_b_, 0.03, 0.01));
}

TEST(KeyframeMatcherNoise, IsTheFollowers) {
  RgbdSlamOptions options;
  options.follow.depth_sigma_m = 0.004;
  options.follow.depth_sigma_per_m2 = 0.003;
  options.follow.min_depth_m = 0.7;
  options.follow.max_depth_m = 4.2;
  EXPECT_NEAR(depth_noise(options).sigma(2.0), 0.016, 1e-12);
  EXPECT_EQ(surface_options(options).depth_sigma_m, 0.004);
  EXPECT_EQ(surface_options(options).depth_sigma_per_m2, 0.003);
  EXPECT_EQ(surface_options(options).min_depth_m, 0.7);
  EXPECT_EQ(surface_options(options).max_depth_m, 4.2);
}

/// As outdoors: of few features a depth was measured.
TEST_F(KeyframeMatcherTest, FarFeaturesCountByTheirDirectionWhereAskedFor) {
  View a = view(pose_a_, 1), b = view(pose_b_, 2);
  const KeyframeMatcher matcher(options_, test_room::camera());
  const auto far_but_every = [](const View& view, std::size_t every) {
    auto keyframe = std::make_shared<ImageFeatures>(*view.keyframe);
    for (std::size_t i = 0; i < keyframe->depths.size(); ++i)
      if (i % every != 0) keyframe->depths[i] = 0.0F;
    return keyframe;
  };
  a.keyframe = far_but_every(a, 20), b.keyframe = far_but_every(b, 20);
  options_.few_features = "refuse";
  const KeyframeMatcher refusing(options_, test_room::camera());
  const auto found = [&](bool far) {
    MatchRequest request;
    request.far = far;
    return refusing.match({a.keyframe.get(), [&] { return a.surface; }}, {b.keyframe.get(), [&] { return b.surface; }},
                          request);
  };
  EXPECT_FALSE(found(false));
  ASSERT_TRUE(found(true));
  EXPECT_THAT(found(true)->a_from_b, pose_near(pose_a_.inverse() * pose_b_, 0.06, 0.02));
  EXPECT_GT(matcher.matches_of(*a.keyframe, *b.keyframe, true).size(),
            3 * matcher.matches_of(*a.keyframe, *b.keyframe).size());
}

TEST_F(KeyframeMatcherTest, ThePositionMustBeKnownAsWellAsAsked) {
  const View a = view(pose_a_, 1), b = view(pose_b_, 2);
  const auto found = [&](double max_sigma_m) {
    MatchRequest request;
    request.max_sigma_m = max_sigma_m;
    return KeyframeMatcher(options_, test_room::camera())
        .match({a.keyframe.get(), [&] { return a.surface; }}, {b.keyframe.get(), [&] { return b.surface; }}, request);
  };
  const auto constraint = match(a, b);
  ASSERT_TRUE(constraint);
  const Eigen::Matrix3d covariance = constraint->information.inverse().topLeftCorner<3, 3>();
  const double sigma_m = std::sqrt(covariance.eigenvalues().real().maxCoeff());
  EXPECT_TRUE(found(1.001 * sigma_m));
  EXPECT_FALSE(found(0.999 * sigma_m));
}

}  // namespace
}  // namespace rastro
