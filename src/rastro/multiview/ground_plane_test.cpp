// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/ground_plane.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "rastro/base/random.h"
#include "rastro/math/so3.h"
#include "rastro/multiview/scene_testing.h"

namespace rastro {
namespace {

/// Points of a road 1.65 m below a camera that looks down by `pitch_rad` and leans by `roll_rad`, in its frame.
std::vector<Eigen::Vector3d> road(Random& random, int count, double pitch_rad, double roll_rad, double noise) {
  const SO3 camera_from_level = SO3::exp({0.0, 0.0, roll_rad}) * SO3::exp({pitch_rad, 0.0, 0.0});
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d level(random.uniform(-4, 4), 1.65, random.uniform(5, 20));
    points.push_back(camera_from_level * level * (1.0 + noise * random.normal()));
  }
  return points;
}

void add_walls(Random& random, int count, std::vector<Eigen::Vector3d>& points) {
  for (int i = 0; i < count; ++i) {
    points.emplace_back(random.uniform() < 0.5 ? -5.0 : 5.0, random.uniform(-4.0, 1.6), random.uniform(5, 25));
  }
}

TEST(GroundHeight, IsExactOnALevelRoad) {
  Random random(1);
  const auto points = road(random, 50, 0.0, 0.0, 0.0);
  const auto ground = estimate_ground_height(points, {});
  ASSERT_TRUE(ground);
  EXPECT_NEAR(ground->height, 1.65, 1e-8);
  EXPECT_LT(testing::angle_between(ground->normal, Eigen::Vector3d::UnitY()), 1e-8);
  EXPECT_EQ(ground->support, 50);
}

TEST(GroundHeight, FindsTheRoadBetweenWallsInAnyUnit) {
  for (const double unit : {1.0, 0.037, 250.0}) {
    Random random(2);
    auto points = road(random, 60, 0.0, 0.0, 0.02);
    add_walls(random, 120, points);
    for (auto& p : points) p *= unit;
    const auto ground = estimate_ground_height(points, {});
    ASSERT_TRUE(ground);
    EXPECT_NEAR(ground->height / unit, 1.65, 0.03);
    EXPECT_LT(testing::angle_between(ground->normal, Eigen::Vector3d::UnitY()), 0.02);
    EXPECT_GE(ground->support, 55);
  }
}

TEST(GroundHeight, KnowsThePitchAndFindsASmallTilt) {
  Random random(3);
  const auto points = road(random, 80, 0.1, 0.02, 0.005);
  const auto ground = estimate_ground_height(points, {.pitch_rad = 0.09});
  ASSERT_TRUE(ground);
  EXPECT_NEAR(ground->height, 1.65, 0.02);
  const Eigen::Vector3d down = SO3::exp({0.0, 0.0, 0.02}) * SO3::exp({0.1, 0.0, 0.0}) * Eigen::Vector3d::UnitY().eval();
  EXPECT_LT(testing::angle_between(ground->normal, down), 0.005);
  const auto fixed = estimate_ground_height(points, {.pitch_rad = 0.1, .max_tilt_deg = 0.0});
  ASSERT_TRUE(fixed);
  EXPECT_NEAR(fixed->normal.x(), 0.0, 1e-15);
}

TEST(GroundHeight, TooFewPointsOrNoGroundGiveNone) {
  Random random(4);
  EXPECT_FALSE(estimate_ground_height({}, {}));
  EXPECT_FALSE(estimate_ground_height(road(random, 8, 0.0, 0.0, 0.0), {}));
  std::vector<Eigen::Vector3d> sky;
  for (int i = 0; i < 50; ++i) sky.emplace_back(random.uniform(-5, 5), -2.0, random.uniform(5, 20));
  EXPECT_FALSE(estimate_ground_height(sky, {}));
  std::vector<Eigen::Vector3d> scattered;
  for (int i = 0; i < 40; ++i) scattered.emplace_back(0.0, std::exp(random.uniform(-3, 3)), 5.0);
  EXPECT_FALSE(estimate_ground_height(scattered, {}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(estimate_ground_height(std::vector<Eigen::Vector3d>(50, {nan, nan, nan}), {}));
}

}  // namespace
}  // namespace rastro
