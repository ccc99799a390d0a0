// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/local_motion.h"

#include <gtest/gtest.h>

#include "rastro/base/random.h"

namespace rastro {
namespace {

/// Two surfaces that move apart: the left half by (10, 0), the right half by (-5, 3).
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
  EXPECT_TRUE(agrees_with_neighbours(pairs, {100, 200}, {110, 200}, 3.0));
  EXPECT_TRUE(agrees_with_neighbours(pairs, {500, 200}, {495, 203}, 3.0));
  EXPECT_FALSE(agrees_with_neighbours(pairs, {100, 200}, {95, 203}, 3.0));
  EXPECT_FALSE(agrees_with_neighbours(pairs, {500, 200}, {510, 200}, 3.0));
}

TEST(LocalMotion, NoNeighboursNoConfirmation) { EXPECT_FALSE(agrees_with_neighbours({}, {1, 1}, {1, 1}, 3.0)); }

TEST(LocalMotion, ItsOwnPairHasNoSay) {
  PointPairs pairs;
  pairs.add({50, 50}, {90, 90});
  for (int i = 0; i < 4; ++i) pairs.add({50.0F + 30.0F * i, 20}, {50.0F + 30.0F * i, 20});
  EXPECT_FALSE(agrees_with_neighbours(pairs, {50, 50}, {90, 90}, 3.0));
}

}  // namespace
}  // namespace rastro
