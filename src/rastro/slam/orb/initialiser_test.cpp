// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/initialiser.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/frame_testing.h"

namespace rastro {
namespace {

using testing::Look;
using testing::LookOptions;
using testing::PointWorld;
using testing::pose_near;

/// To the right, a little forward and turned.
SE3 start_motion() { return SE3(SO3::exp({0.01, -0.02, 0.015}), {-0.4, 0.05, -0.1}); }

SE3 slid_to(double x) { return SE3(SO3(), {-x, 0.0, 0.0}); }

/// Motion and points are those of the world, of which `second_from_first` is known, up to scale.
void expect_true_start(const StartPair& start, const PointWorld& world, const Look& first, const Look& second,
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
    const Eigen::Vector3d truth = world_from_first.inverse() * world.points[point];
    EXPECT_LT((scale * *start.points[i] - truth).norm(), 2e-3 * truth.norm());
  }
  EXPECT_GT(known, start.pairs.size() * 9 / 10);
}

TEST(Initialiser, TwoViewsWithParallaxBeginWithTheTrueMotionAndPoints) {
  const PointWorld world(300, 1);
  const SE3 first_pose(SO3::exp({0.02, 0.01, -0.03}), {0.05, 0.02, 0.1});
  const Look first = world.look(0, first_pose), second = world.look(1, start_motion() * first_pose);
  Initialiser initialiser({}, world.camera);
  EXPECT_FALSE(initialiser.add(first.frame));
  EXPECT_EQ(initialiser.detail(), "the first frame");
  const auto start = initialiser.add(second.frame);
  ASSERT_TRUE(start) << initialiser.detail();
  EXPECT_EQ(start->first, 0U);
  EXPECT_EQ(start->second, 1U);
  EXPECT_GT(start->pairs.size(), 280U);
  expect_true_start(*start, world, first, second, first_pose.inverse(), start_motion());
}

TEST(Initialiser, WaitsForParallaxAndHoldsTheFirstFrameUntilThere) {
  const PointWorld world(300, 2);
  Initialiser initialiser({}, world.camera);
  std::vector<Look> looks;
  std::optional<StartPair> start;
  for (int k = 0; k < 20 && !start; ++k) {
    looks.push_back(world.look(k, slid_to(0.03 * k)));
    start = initialiser.add(looks.back().frame);
    if (k == 0 || start) continue;
    EXPECT_THAT(initialiser.detail(), ::testing::MatchesRegex("median parallax 0\\.[0-9] deg, need 1\\.0"));
  }
  ASSERT_TRUE(start);
  // Half of the points are beyond 8 m: a degree takes some 0.14 m.
  EXPECT_NEAR(static_cast<double>(start->second), 0.14 / 0.03, 1.5);
  EXPECT_EQ(start->first, 0U);
  const double gone = 0.03 * static_cast<double>(start->second);
  expect_true_start(*start, world, looks[0], looks.back(), SE3(), slid_to(gone));
}

TEST(Initialiser, ATurnOnTheSpotNeverBegins) {
  const PointWorld world(300, 3);
  Initialiser initialiser({}, world.camera);
  initialiser.add(world.look(0, SE3()).frame);
  for (int k = 1; k < 6; ++k) {
    const SE3 turned(SO3::exp({0.004 * k, -0.02 * k, 0.006 * k}), Eigen::Vector3d::Zero());
    EXPECT_FALSE(initialiser.add(world.look(k, turned, {.noise_px = 0.5}).frame));
    EXPECT_THAT(initialiser.detail(), ::testing::MatchesRegex("median parallax 0\\.[0-9] deg, need 1\\.0"));
  }
  EXPECT_EQ(initialiser.frames().size(), 6U);
}

TEST(Initialiser, SaysHowManyMatchesAreMissing) {
  const PointWorld world(60, 4);
  Initialiser initialiser({}, world.camera);
  initialiser.add(world.look(0, SE3()).frame);
  EXPECT_FALSE(initialiser.add(world.look(1, slid_to(0.3)).frame));
  EXPECT_EQ(initialiser.detail(), "60 matches, need 100");
}

TEST(Initialiser, AFrameThatLooksLikeNoLaterOneGivesWay) {
  const PointWorld before(300, 5), world(300, 6);
  Initialiser initialiser({}, world.camera);
  initialiser.add(before.look(0, SE3()).frame);
  EXPECT_FALSE(initialiser.add(world.look(1, SE3()).frame));
  EXPECT_EQ(initialiser.detail(), "0 matches, need 100");
  const Look first = world.look(1, SE3()), second = world.look(2, start_motion());
  const auto start = initialiser.add(second.frame);
  ASSERT_TRUE(start) << initialiser.detail();
  EXPECT_EQ(start->first, 1U);
  EXPECT_EQ(start->second, 2U);
  expect_true_start(*start, world, first, second, SE3(), start_motion());
}

TEST(Initialiser, WhereNoMotionFitsANearerFrameTakesThePlaceOfTheFirst) {
  const PointWorld world(300, 7);
  Initialiser initialiser({}, world.camera);
  // Everything is somewhere else in the first frame, but near enough to be matched.
  initialiser.add(world.look(0, SE3(), {.moved_share = 1.0}).frame);
  EXPECT_FALSE(initialiser.add(world.look(1, SE3()).frame));
  const Look first = world.look(1, SE3()), second = world.look(2, start_motion());
  const auto start = initialiser.add(second.frame);
  ASSERT_TRUE(start) << initialiser.detail();
  EXPECT_EQ(start->first, 1U);
  expect_true_start(*start, world, first, second, SE3(), start_motion());
}

TEST(Initialiser, ForgetsTheOldestFramesAndStillNamesTheRightOnes) {
  const PointWorld before(300, 80), world(300, 8);
  OrbSlamOptions options;
  options.init_frames = 3;
  Initialiser initialiser(options, world.camera);
  for (int k = 0; k < 8; ++k) {
    // The first frame gives way to the second, which is forgotten later.
    EXPECT_FALSE(initialiser.add((k == 0 ? before : world).look(k, slid_to(0.02 * k)).frame));
    EXPECT_EQ(initialiser.frames().size(), static_cast<std::size_t>(std::min(k + 1, 3)));
    EXPECT_EQ(initialiser.frames().back()->data().id, k);
  }
  const Look first = world.look(6, slid_to(0.12)), second = world.look(8, slid_to(0.5));
  const auto start = initialiser.add(second.frame);
  ASSERT_TRUE(start) << initialiser.detail();
  EXPECT_EQ(initialiser.frames()[start->first]->data().id, 6);
  EXPECT_EQ(initialiser.frames()[start->second]->data().id, 8);
  expect_true_start(*start, world, first, second, slid_to(0.12).inverse(), slid_to(0.38));
}

TEST(Initialiser, BeginsAnewOnceCleared) {
  const PointWorld world(300, 9);
  Initialiser initialiser({}, world.camera);
  initialiser.add(world.look(0, SE3()).frame);
  initialiser.clear();
  EXPECT_TRUE(initialiser.frames().empty());
  EXPECT_EQ(initialiser.detail(), "");
  EXPECT_FALSE(initialiser.add(world.look(1, start_motion()).frame));
  EXPECT_EQ(initialiser.detail(), "the first frame");
  EXPECT_TRUE(initialiser.add(world.look(2, SE3()).frame));
}

TEST(Initialiser, WhatIsKeptServesTheNextFrameAsItsFirst) {
  const PointWorld world(300, 10);
  Initialiser initialiser({}, world.camera);
  const Look first = world.look(0, SE3()), second = world.look(1, start_motion());
  initialiser.keep(first.frame);
  const auto start = initialiser.add(second.frame);
  ASSERT_TRUE(start) << initialiser.detail();
  expect_true_start(*start, world, first, second, SE3(), start_motion());
}

/// All numbers of a start from noisy frames with outliers.
std::vector<double> start_numbers(std::uint64_t seed) {
  const PointWorld world(300, 11);
  OrbSlamOptions options;
  options.seed = seed;
  Initialiser initialiser(options, world.camera);
  initialiser.add(world.look(0, SE3(), {.noise_px = 0.5, .seed = 1}).frame);
  const auto start =
      initialiser.add(world.look(1, start_motion(), {.noise_px = 0.5, .moved_share = 0.2, .seed = 2}).frame);
  EXPECT_TRUE(start) << initialiser.detail();
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

TEST(Initialiser, SameSeedSameBytes) {
  const std::vector<double> numbers = start_numbers(1);
  EXPECT_EQ(numbers, start_numbers(1));
  EXPECT_NE(numbers, start_numbers(2)) << "the seed reaches the sampling";
}

}  // namespace
}  // namespace rastro
