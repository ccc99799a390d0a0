// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/initialization/initializer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/tracking/frame_testing.h"

namespace rastro {
namespace {

using testing::Observed;
using testing::ObserveOptions;
using testing::PointWorld;
using testing::pose_near;

/// To the right, a little forward, with a rotation.
SE3 start_motion() { return SE3(SO3::exp({0.01, -0.02, 0.015}), {-0.4, 0.05, -0.1}); }

SE3 slid_to(double x) { return SE3(SO3(), {-x, 0.0, 0.0}); }

/// Motion and points are those of the world up to scale; `second_from_first` is the true motion.
void expect_true_start(const InitialPair& start, const PointWorld& world, const Observed& first, const Observed& second,
                       const SE3& world_from_first, const SE3& second_from_first) {
  const double scale = second_from_first.translation().norm();
  const SE3 unit(second_from_first.rotation(), second_from_first.translation() / scale);
  EXPECT_THAT(start.second_from_first, pose_near(unit, 1e-3, 1e-4));
  ASSERT_EQ(start.points.size(), start.pairs.size());
  std::size_t known = 0;
  for (std::size_t i = 0; i < start.pairs.size(); ++i) {
    const std::uint32_t point = first.seen[start.pairs[i].first];
    EXPECT_EQ(point, second.seen[start.pairs[i].second]);
    if (!start.points[i]) continue;
    ++known;
    const Eigen::Vector3d ground_truth = world_from_first.inverse() * world.points[point];
    EXPECT_LT((scale * *start.points[i] - ground_truth).norm(), 2e-3 * ground_truth.norm());
  }
  EXPECT_GT(known, start.pairs.size() * 9 / 10);
}

TEST(Initializer, TwoViewsWithParallaxGiveTheTrueMotionAndPoints) {
  const PointWorld world(300, 1);
  const SE3 first_pose(SO3::exp({0.02, 0.01, -0.03}), {0.05, 0.02, 0.1});
  const Observed first = world.observe(0, first_pose), second = world.observe(1, start_motion() * first_pose);
  Initializer initializer({}, world.camera);
  EXPECT_FALSE(initializer.add(first.frame));
  EXPECT_EQ(initializer.detail(), "the first frame");
  const auto start = initializer.add(second.frame);
  ASSERT_TRUE(start) << initializer.detail();
  EXPECT_EQ(start->first, 0U);
  EXPECT_EQ(start->second, 1U);
  EXPECT_GT(start->pairs.size(), 280U);
  expect_true_start(*start, world, first, second, first_pose.inverse(), start_motion());
}

TEST(Initializer, AMapNeedsAsManyPointsAsTheOptionSays) {
  const PointWorld world(300, 1);
  OrbSlamOptions options;
  options.init_points = 1000;
  Initializer initializer(options, world.camera);
  initializer.add(world.observe(0, SE3()).frame);
  EXPECT_FALSE(initializer.add(world.observe(1, start_motion()).frame));
  EXPECT_NE(initializer.detail().find("1000"), std::string::npos) << initializer.detail();
}

TEST(Initializer, WaitsForParallaxAndKeepsTheFirstFrameUntilThen) {
  const PointWorld world(300, 2);
  Initializer initializer({}, world.camera);
  std::vector<Observed> views;
  std::optional<InitialPair> start;
  for (int k = 0; k < 20 && !start; ++k) {
    views.push_back(world.observe(k, slid_to(0.03 * k)));
    start = initializer.add(views.back().frame);
    if (k == 0 || start) continue;
    EXPECT_THAT(initializer.detail(), ::testing::MatchesRegex("median parallax 0\\.[0-9] deg, need 1\\.0"));
  }
  ASSERT_TRUE(start);
  // Half of the points are beyond 8 m: one degree of parallax needs about 0.14 m.
  EXPECT_NEAR(static_cast<double>(start->second), 0.14 / 0.03, 1.5);
  EXPECT_EQ(start->first, 0U);
  const double gone = 0.03 * static_cast<double>(start->second);
  expect_true_start(*start, world, views[0], views.back(), SE3(), slid_to(gone));
}

TEST(Initializer, ARotationInPlaceNeverInitializes) {
  const PointWorld world(300, 3);
  Initializer initializer({}, world.camera);
  initializer.add(world.observe(0, SE3()).frame);
  for (int k = 1; k < 6; ++k) {
    const SE3 rotated(SO3::exp({0.004 * k, -0.02 * k, 0.006 * k}), Eigen::Vector3d::Zero());
    EXPECT_FALSE(initializer.add(world.observe(k, rotated, {.noise_px = 0.5}).frame));
    EXPECT_THAT(initializer.detail(), ::testing::MatchesRegex("median parallax 0\\.[0-9] deg, need 1\\.0"));
  }
  EXPECT_EQ(initializer.frames().size(), 6U);
}

TEST(Initializer, ReportsHowManyMatchesAreMissing) {
  const PointWorld world(60, 4);
  Initializer initializer({}, world.camera);
  initializer.add(world.observe(0, SE3()).frame);
  EXPECT_FALSE(initializer.add(world.observe(1, slid_to(0.3)).frame));
  EXPECT_EQ(initializer.detail(), "needs at least 100 matches, got 60");
}

TEST(Initializer, AFrameThatMatchesNoLaterOneIsReplaced) {
  const PointWorld before(300, 5), world(300, 6);
  Initializer initializer({}, world.camera);
  initializer.add(before.observe(0, SE3()).frame);
  EXPECT_FALSE(initializer.add(world.observe(1, SE3()).frame));
  EXPECT_EQ(initializer.detail(), "needs at least 100 matches, got 0");
  const Observed first = world.observe(1, SE3()), second = world.observe(2, start_motion());
  const auto start = initializer.add(second.frame);
  ASSERT_TRUE(start) << initializer.detail();
  EXPECT_EQ(start->first, 1U);
  EXPECT_EQ(start->second, 2U);
  expect_true_start(*start, world, first, second, SE3(), start_motion());
}

TEST(Initializer, IfNoMotionFitsANearerFrameReplacesTheFirst) {
  const PointWorld world(300, 7);
  Initializer initializer({}, world.camera);
  // All features are elsewhere in the first frame, but near enough to be matched.
  initializer.add(world.observe(0, SE3(), {.moved_share = 1.0}).frame);
  EXPECT_FALSE(initializer.add(world.observe(1, SE3()).frame));
  const Observed first = world.observe(1, SE3()), second = world.observe(2, start_motion());
  const auto start = initializer.add(second.frame);
  ASSERT_TRUE(start) << initializer.detail();
  EXPECT_EQ(start->first, 1U);
  expect_true_start(*start, world, first, second, SE3(), start_motion());
}

/// Frame 2, halfway between, is as bad as the first one.
TEST(Initializer, ANearerFrameWithoutAMotionIsPassedOver) {
  const PointWorld world(300, 7);
  Initializer initializer({}, world.camera);
  for (const int k : {0, 1, 2, 3}) {
    const double moved = k % 2 == 0 ? 1.0 : 0.0;
    EXPECT_FALSE(initializer.add(
        world.observe(k, SE3(), {.moved_share = moved, .seed = static_cast<std::uint64_t>(k + 1)}).frame));
  }
  const Observed first = world.observe(3, SE3()), second = world.observe(4, start_motion());
  const auto start = initializer.add(second.frame);
  ASSERT_TRUE(start) << initializer.detail();
  EXPECT_EQ(start->first, 3U);
  expect_true_start(*start, world, first, second, SE3(), start_motion());
}

TEST(Initializer, DropsTheOldestFramesAndKeepsTheIndicesCorrect) {
  const PointWorld before(300, 80), world(300, 8);
  OrbSlamOptions options;
  options.init_frames = 3;
  Initializer initializer(options, world.camera);
  for (int k = 0; k < 8; ++k) {
    // The second frame replaces the first, which is dropped later.
    EXPECT_FALSE(initializer.add((k == 0 ? before : world).observe(k, slid_to(0.02 * k)).frame));
    EXPECT_EQ(initializer.frames().size(), static_cast<std::size_t>(std::min(k + 1, 3)));
    EXPECT_EQ(initializer.frames().back()->data().id, k);
  }
  const Observed first = world.observe(6, slid_to(0.12)), second = world.observe(8, slid_to(0.5));
  const auto start = initializer.add(second.frame);
  ASSERT_TRUE(start) << initializer.detail();
  EXPECT_EQ(initializer.frames()[start->first]->data().id, 6);
  EXPECT_EQ(initializer.frames()[start->second]->data().id, 8);
  expect_true_start(*start, world, first, second, slid_to(0.12).inverse(), slid_to(0.38));
}

TEST(Initializer, StartsAgainOnceCleared) {
  const PointWorld world(300, 9);
  Initializer initializer({}, world.camera);
  initializer.add(world.observe(0, SE3()).frame);
  initializer.clear();
  EXPECT_TRUE(initializer.frames().empty());
  EXPECT_EQ(initializer.detail(), "");
  EXPECT_FALSE(initializer.add(world.observe(1, start_motion()).frame));
  EXPECT_EQ(initializer.detail(), "the first frame");
  EXPECT_TRUE(initializer.add(world.observe(2, SE3()).frame));
}

TEST(Initializer, AKeptFrameIsTheFirstOfTheNextPair) {
  const PointWorld world(300, 10);
  Initializer initializer({}, world.camera);
  const Observed first = world.observe(0, SE3()), second = world.observe(1, start_motion());
  initializer.keep(first.frame);
  const auto start = initializer.add(second.frame);
  ASSERT_TRUE(start) << initializer.detail();
  expect_true_start(*start, world, first, second, SE3(), start_motion());
}

/// All numbers of an initialization from noisy frames with outliers.
std::vector<double> start_numbers(std::uint64_t seed) {
  const PointWorld world(300, 11);
  OrbSlamOptions options;
  options.seed = seed;
  Initializer initializer(options, world.camera);
  initializer.add(world.observe(0, SE3(), {.noise_px = 0.5, .seed = 1}).frame);
  const auto start =
      initializer.add(world.observe(1, start_motion(), {.noise_px = 0.5, .moved_share = 0.2, .seed = 2}).frame);
  EXPECT_TRUE(start) << initializer.detail();
  std::vector<double> numbers;
  if (!start) return numbers;
  const Eigen::Matrix4d matrix = start->second_from_first.matrix();
  numbers.assign(matrix.data(), matrix.data() + 16);
  for (const auto& point : start->points) {
    numbers.push_back(point ? 1.0 : 0.0);
    if (point) numbers.insert(numbers.end(), point->data(), point->data() + 3);
  }
  return numbers;
}

TEST(Initializer, SameSeedSameBytes) {
  const std::vector<double> numbers = start_numbers(1);
  EXPECT_EQ(numbers, start_numbers(1));
  EXPECT_NE(numbers, start_numbers(2)) << "the seed reaches the sampling";
}

}  // namespace
}  // namespace rastro
