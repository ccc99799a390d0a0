// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/two_view_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "rastro/base/random.h"
#include "rastro/math/math_testing.h"

namespace rastro {
namespace {

using testing::pose_near;

const SE3 true_a_from_b(SO3::exp({0.06, -0.1, 0.04}), {0.12, -0.05, 0.08});

/// Which of the two depths were measured.
enum class Depths { both, of_a, of_b, mixed, few };

/// Points 1 to 4 m in front of b, without noise.
std::vector<PointMatch> exact_matches(std::size_t count, Depths depths = Depths::both, std::uint64_t seed = 3) {
  Random random(seed);
  std::vector<PointMatch> matches;
  while (matches.size() < count) {
    const double z = random.uniform(1.0, 4.0);
    const Eigen::Vector3d in_b(z * random.uniform(-0.5, 0.5), z * random.uniform(-0.4, 0.4), z);
    const Eigen::Vector3d in_a = true_a_from_b * in_b;
    PointMatch match{in_a.hnormalized(), in_b.hnormalized(), in_a.z(), in_b.z(), 1.0, 1.0};
    const std::size_t kind = matches.size() % 3;
    if (depths == Depths::of_b || (depths == Depths::mixed && kind == 1)) match.depth_a = 0.0;
    if (depths == Depths::of_a || (depths == Depths::mixed && kind == 2)) match.depth_b = 0.0;
    if (depths == Depths::few && kind > 0) match.depth_a = match.depth_b = 0.0;
    matches.push_back(match);
  }
  return matches;
}

/// The noise of the options: half a pixel in each direction at 500 px focal length, and the depth noise.
std::vector<PointMatch> noisy(std::vector<PointMatch> matches, const PointMatchOptions& options, Random& random) {
  const auto disturb = [&](Eigen::Vector2d& ray, double& depth, double sigma_px) {
    for (double& value : ray) value += sigma_px / options.focal_px * random.normal();
    if (depth > 0.0) depth += options.noise.sigma(depth) * random.normal();
  };
  for (PointMatch& match : matches) {
    match.sigma_a = match.sigma_b = 0.5;
    disturb(match.ray_a, match.depth_a, match.sigma_a);
    disturb(match.ray_b, match.depth_b, match.sigma_b);
  }
  return matches;
}

/// The first `count` are matched to features anywhere in a's image.
void make_outliers(std::vector<PointMatch>& matches, std::size_t count, std::uint64_t seed) {
  Random random(seed);
  for (std::size_t i = 0; i < count; ++i) {
    matches[i].ray_a = {random.uniform(-0.6, 0.6), random.uniform(-0.45, 0.45)};
    if (matches[i].depth_a > 0.0) matches[i].depth_a = random.uniform(1.0, 4.0);
  }
}

TEST(PointMatches, ExactMatchesGiveTheExactMotionWithAnyDepths) {
  for (const Depths depths : {Depths::both, Depths::of_a, Depths::of_b, Depths::mixed, Depths::few}) {
    const auto views = estimate_views(exact_matches(60, depths), {});
    ASSERT_TRUE(views) << static_cast<int>(depths);
    EXPECT_THAT(views->a_from_b, pose_near(true_a_from_b, 1e-7, 1e-7)) << static_cast<int>(depths);
    EXPECT_EQ(views->inliers, 60);
  }
}

/// d^T information d has the mean 6 if the covariance is correct. The kernel reduces the weight of some good matches,
/// so it may be less; 8 would mean a covariance too small by a third.
TEST(PointMatches, TheInformationIsConsistentWithTheErrors) {
  for (const Depths depths : {Depths::both, Depths::of_a, Depths::of_b, Depths::few}) {
    PointMatchOptions options;
    Random random(11);
    double sum = 0.0;
    constexpr int runs = 150;
    for (int run = 0; run < runs; ++run) {
      options.seed = static_cast<std::uint64_t>(run);
      const auto views = estimate_views(noisy(exact_matches(80, depths, options.seed), options, random), options);
      ASSERT_TRUE(views);
      const Vector6d error = (views->a_from_b.inverse() * true_a_from_b).log();
      sum += error.dot(views->information * error);
    }
    EXPECT_GT(sum / runs, 3.0) << static_cast<int>(depths);
    EXPECT_LT(sum / runs, 8.0) << static_cast<int>(depths);
  }
}

/// Three points with a depth and noise, among many far away without.
TEST(PointMatches, DirectionsAloneMakeTheMotionMoreCertain) {
  PointMatchOptions options;
  options.min_inliers = options.min_depth_inliers = 6;
  Random random(5);
  auto matches = noisy(exact_matches(90, Depths::few), options, random);
  std::vector<PointMatch> with_depth;
  std::copy_if(matches.begin(), matches.end(), std::back_inserter(with_depth),
               [](const PointMatch& match) { return match.has_depth(); });
  ASSERT_EQ(with_depth.size(), 30U);
  const auto without = estimate_views(with_depth, options), all = estimate_views(matches, options);
  ASSERT_TRUE(without && all);
  EXPECT_LE(without->inliers, 30);
  EXPECT_GT(all->inliers, 80);
  EXPECT_GT(all->information.determinant(), 4.0 * without->information.determinant());
}

TEST(PointMatches, ADirectionCountsOnlyWhereItsRayIsSeen) {
  PointMatchOptions options;
  std::vector<PointMatch> matches = exact_matches(60, Depths::few);
  const auto turned_away = [&](std::size_t i, double by) {
    const Eigen::Vector3d at_infinity = true_a_from_b.rotation() * matches[i].ray_b.homogeneous();
    const Eigen::Vector3d nearest = true_a_from_b * (options.min_depth_m * matches[i].ray_b.homogeneous());
    const Eigen::Vector2d from = at_infinity.hnormalized(), to = nearest.hnormalized();
    matches[i].ray_a = from + by * (to - from);
  };
  turned_away(1, 0.0), turned_away(2, 1.0), turned_away(4, -0.1), turned_away(5, 1.1);
  matches[7].ray_a.y() += 0.05;
  EXPECT_EQ(estimate_views(matches, options)->inliers, 57) << "beyond infinity, too near, and beside";
}

TEST(PointMatches, DirectionsAloneGiveNoMotion) {
  std::vector<PointMatch> matches = exact_matches(60);
  for (std::size_t i = 5; i < 60; ++i) matches[i].depth_a = matches[i].depth_b = 0.0;
  EXPECT_FALSE(estimate_views(matches, {})) << "five have a depth";
  matches[5] = exact_matches(6)[5];
  EXPECT_TRUE(estimate_views(matches, {}));
}

TEST(PointMatches, LargeResidualsMakeTheMotionLessCertain) {
  PointMatchOptions options;
  Random random(4);
  const auto matches = noisy(exact_matches(100), options, random);
  auto claimed = matches;  // the same residuals, claimed to be a fifth as large
  for (PointMatch& match : claimed) match.sigma_a = match.sigma_b = 0.1;
  options.max_sigmas = 30.0;
  const auto honest = estimate_views(matches, options), too_sure = estimate_views(claimed, options);
  ASSERT_TRUE(honest && too_sure);
  EXPECT_LT(too_sure->information.trace(), 8.0 * honest->information.trace()) << "25 times by what was claimed";
}

TEST(PointMatches, OutliersHaveNoInfluence) {
  PointMatchOptions options;
  for (const Depths depths : {Depths::both, Depths::of_a, Depths::of_b, Depths::mixed}) {
    Random random(8);
    auto matches = noisy(exact_matches(120, depths), options, random);
    make_outliers(matches, 60, 21);
    const auto views = estimate_views(matches, options);
    ASSERT_TRUE(views) << static_cast<int>(depths);
    EXPECT_THAT(views->a_from_b, pose_near(true_a_from_b, 0.01, 0.005)) << static_cast<int>(depths);
    EXPECT_GE(views->inliers, 54) << static_cast<int>(depths);
    EXPECT_LE(views->inliers, 64) << "an outlier is close to its position by chance only";
  }
}

TEST(PointMatches, AMatchWithTheRightPixelAndTheWrongDepthIsAnOutlier) {
  auto matches = exact_matches(60);
  for (std::size_t i = 0; i < 20; ++i) matches[i].depth_a *= 1.25;
  const auto views = estimate_views(matches, {});
  ASSERT_TRUE(views);
  EXPECT_EQ(views->inliers, 40);
  EXPECT_THAT(views->a_from_b, pose_near(true_a_from_b, 1e-6, 1e-6));
}

TEST(PointMatches, FewerThanAskedForAreRefused) {
  PointMatchOptions options;
  options.min_inliers = 20;
  EXPECT_TRUE(estimate_views(exact_matches(20), options));
  EXPECT_FALSE(estimate_views(exact_matches(19), options));
  auto matches = exact_matches(60);
  make_outliers(matches, 41, 5);
  EXPECT_FALSE(estimate_views(matches, options)) << "19 agree, among many that do not";
  EXPECT_FALSE(estimate_views({}, options));
  options.min_inliers = 1;
  EXPECT_FALSE(estimate_views(exact_matches(3), options)) << "three fit anything";
}

TEST(PointMatches, MatchesAtRandomGiveNothing) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    auto matches = exact_matches(80);
    make_outliers(matches, matches.size(), seed);
    EXPECT_FALSE(estimate_views(matches, {})) << seed;
  }
}

TEST(PointMatches, ADepthOfNanCountsAsNone) {
  auto none = exact_matches(60, Depths::mixed), nan = none;
  for (PointMatch& match : nan) {
    for (double* depth : {&match.depth_a, &match.depth_b})
      if (*depth == 0.0) *depth = std::numeric_limits<double>::quiet_NaN();
  }
  const auto of_none = estimate_views(none, {}), of_nan = estimate_views(nan, {});
  ASSERT_TRUE(of_none && of_nan);
  EXPECT_EQ(of_none->inliers, of_nan->inliers);
  EXPECT_EQ(of_none->a_from_b.matrix(), of_nan->a_from_b.matrix());
}

TEST(PointMatches, MatchesWithoutAnyDepthCountByTheirDirection) {
  auto matches = exact_matches(60);
  for (std::size_t i = 0; i < 15; ++i) {
    matches[i].depth_a = matches[i].depth_b = i % 2 == 0 ? 0.0 : std::numeric_limits<double>::quiet_NaN();
  }
  const auto views = estimate_views(matches, {});
  ASSERT_TRUE(views);
  EXPECT_EQ(views->inliers, 60);
  EXPECT_THAT(views->a_from_b, pose_near(true_a_from_b, 1e-6, 1e-6));
}

TEST(PointMatches, PointsOnALineDoNotDetermineThePose) {
  std::vector<PointMatch> matches;
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector3d in_b = Eigen::Vector3d(-0.5, 0.2, 2.0) + 0.03 * i * Eigen::Vector3d(1.0, 0.3, 0.5);
    const Eigen::Vector3d in_a = true_a_from_b * in_b;
    matches.push_back({in_a.hnormalized(), in_b.hnormalized(), in_a.z(), in_b.z(), 1.0, 1.0});
  }
  EXPECT_FALSE(estimate_views(matches, {}));
  EXPECT_FALSE(estimate_views(matches, {}, true_a_from_b)) << "nor does a guess close it";
}

TEST(PointMatches, TheSameSeedGivesTheSameBits) {
  PointMatchOptions options;
  Random random(2);
  auto matches = noisy(exact_matches(90, Depths::mixed), options, random);
  make_outliers(matches, 40, 6);
  const auto once = estimate_views(matches, options), again = estimate_views(matches, options);
  ASSERT_TRUE(once && again);
  EXPECT_EQ(
      std::memcmp(once->a_from_b.matrix().eval().data(), again->a_from_b.matrix().eval().data(), 16 * sizeof(double)),
      0);
  EXPECT_EQ(std::memcmp(once->information.data(), again->information.data(), 36 * sizeof(double)), 0);
}

TEST(PointMatches, AGuessFindsWhatSamplesWouldMiss) {
  auto matches = exact_matches(200);
  make_outliers(matches, 180, 9);
  PointMatchOptions options;
  options.iterations = 3;  // one sample in a thousand has three inliers
  EXPECT_FALSE(estimate_views(matches, options));
  const SE3 near = true_a_from_b * SE3::exp((Vector6d() << 0.002, -0.001, 0.002, 0.001, 0.0, -0.001).finished());
  const auto views = estimate_views(matches, options, near);
  ASSERT_TRUE(views);
  EXPECT_THAT(views->a_from_b, pose_near(true_a_from_b, 1e-3, 1e-3));
  const SE3 wrong(SO3::exp({0.0, 0.5, 0.0}), {1.0, 0.0, 0.0});
  const auto good = estimate_views(exact_matches(60), {}, wrong);
  ASSERT_TRUE(good);
  EXPECT_THAT(good->a_from_b, pose_near(true_a_from_b, 1e-6, 1e-6)) << "a wrong guess does no harm";
}

/// The opposite direction gives the inverse, with the same certainty.
TEST(PointMatches, FromTheOtherViewItIsTheInverse) {
  PointMatchOptions options;
  Random random(13);
  const auto matches = noisy(exact_matches(150), options, random);
  auto swapped = matches;
  for (PointMatch& match : swapped) {
    std::swap(match.ray_a, match.ray_b);
    std::swap(match.depth_a, match.depth_b);
  }
  const auto there = estimate_views(matches, options), back = estimate_views(swapped, options);
  ASSERT_TRUE(there && back);
  EXPECT_THAT(back->a_from_b, pose_near(there->a_from_b.inverse(), 0.002, 0.001));
  const Matrix6d adjoint = there->a_from_b.inverse().adjoint();
  const Matrix6d of_back = adjoint.transpose() * there->information * adjoint;
  EXPECT_NEAR(back->information.trace() / of_back.trace(), 1.0, 0.2);
}

}  // namespace
}  // namespace rastro
