// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/local_motion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/random.h"

namespace rastro {
namespace {

/// Two surfaces moving apart: the left half by (10, 0), the right half by (-5, 3).
PointPairs two_motions(Random& random) {
  PointPairs pairs;
  for (int i = 0; i < 120; ++i) {
    const Eigen::Vector2f a(static_cast<float>(random.uniform(0, 600)), static_cast<float>(random.uniform(0, 400)));
    const Eigen::Vector2f motion = a.x() < 300 ? Eigen::Vector2f(10, 0) : Eigen::Vector2f(-5, 3);
    pairs.add(a, a + motion);
  }
  return pairs;
}

TEST(LocalMotion, FollowsTheNearestSurface) {
  Random random(1);
  const PointPairs pairs = two_motions(random);
  EXPECT_TRUE(agrees_with_neighbors(pairs, {100, 200}, {110, 200}, 3.0));
  EXPECT_TRUE(agrees_with_neighbors(pairs, {500, 200}, {495, 203}, 3.0));
  EXPECT_FALSE(agrees_with_neighbors(pairs, {100, 200}, {95, 203}, 3.0));
  EXPECT_FALSE(agrees_with_neighbors(pairs, {500, 200}, {510, 200}, 3.0));
}

/// The corners of a square of `side` pixels, each moved by a similarity about the origin.
PointPairs moved_square(float side, float scale, const Eigen::Vector2f& shift, int corners = 4) {
  PointPairs pairs;
  for (int i = 0; i < corners; ++i) {
    const Eigen::Vector2f a(i % 2 == 0 ? 0.0F : side, i / 2 == 0 ? 0.0F : side);
    pairs.add(a, scale * a + shift);
  }
  return pairs;
}

TEST(LocalMotion, NeedsFourThatMoveAlike) {
  EXPECT_FALSE(agrees_with_neighbors(moved_square(40, 1, {5, 5}, 3), {20, 20}, {25, 25}, 3.0));
  EXPECT_TRUE(agrees_with_neighbors(moved_square(40, 1, {5, 5}, 4), {20, 20}, {25, 25}, 3.0));
}

TEST(LocalMotion, AgreesUpToTheLargestError) {
  const PointPairs pairs = moved_square(40, 1, {5, 5});
  EXPECT_TRUE(agrees_with_neighbors(pairs, {20, 20}, {25, 27.9}, 3.0));
  EXPECT_FALSE(agrees_with_neighbors(pairs, {20, 20}, {25, 28.1}, 3.0));
}

TEST(LocalMotion, ASimilarityMayGrowOrShrinkUpToTwofold) {
  for (const auto& [scale, likely] : {std::pair{1.95F, true}, {2.05F, false}, {0.52F, true}, {0.48F, false}}) {
    const double middle = 20.0 * static_cast<double>(scale) + 5.0;
    EXPECT_EQ(agrees_with_neighbors(moved_square(40, scale, {5, 5}), {20, 20}, {middle, middle}, 1.0), likely) << scale;
  }
}

TEST(LocalMotion, PairsTooNearToEachOtherGiveNoMotion) {
  EXPECT_FALSE(agrees_with_neighbors(moved_square(10, 1, {5, 5}), {20, 20}, {25, 25}, 3.0)) << "diagonal 14.1 px";
  EXPECT_TRUE(agrees_with_neighbors(moved_square(11, 1, {5, 5}), {20, 20}, {25, 25}, 3.0)) << "diagonal 15.6 px";
}

TEST(LocalMotion, OfTwoEquallySupportedMotionsTheOneThatSuitsSpeaks) {
  PointPairs pairs = moved_square(40, 1, {5, 5});
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector2f a(i % 2 == 0 ? 3.0F : 43.0F, i / 2 == 0 ? 2.0F : 42.0F);
    pairs.add(a, a + Eigen::Vector2f(-30, 12));
  }
  EXPECT_TRUE(agrees_with_neighbors(pairs, {20, 20}, {25, 25}, 3.0));
  EXPECT_TRUE(agrees_with_neighbors(pairs, {20, 20}, {-10, 32}, 3.0));
  EXPECT_FALSE(agrees_with_neighbors(pairs, {20, 20}, {40, 20}, 3.0));
}

TEST(LocalMotion, OnlyTheNearestDozenHasASay) {
  PointPairs pairs;
  const auto ring = [&](int count, float radius, const Eigen::Vector2f& motion) {
    for (int i = 0; i < count; ++i) {
      const float angle = 6.2831853F * static_cast<float>(i) / static_cast<float>(count);
      const Eigen::Vector2f a(300 + radius * std::cos(angle), 200 + radius * std::sin(angle));
      pairs.add(a, a + motion);
    }
  };
  ring(40, 90.0F, {-30, 12});  // many, but farther away
  ring(12, 40.0F, {5, 5});
  EXPECT_TRUE(agrees_with_neighbors(pairs, {300, 200}, {305, 205}, 3.0));
  EXPECT_FALSE(agrees_with_neighbors(pairs, {300, 200}, {270, 212}, 3.0));
}

TEST(LocalMotion, WithoutNeighborsThereIsNoConfirmation) {
  EXPECT_FALSE(agrees_with_neighbors({}, {1, 1}, {1, 1}, 3.0));
}

TEST(LocalMotion, IgnoresItsOwnMatch) {
  PointPairs pairs;
  pairs.add({50, 50}, {90, 90});
  for (int i = 0; i < 4; ++i) pairs.add({50.0F + 30.0F * i, 20}, {50.0F + 30.0F * i, 20});
  EXPECT_FALSE(agrees_with_neighbors(pairs, {50, 50}, {90, 90}, 3.0));
}

}  // namespace
}  // namespace rastro
