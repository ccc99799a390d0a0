// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/scan_features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "rastro/math/math_testing.h"
#include "rastro/slam/ekf/association.h"
#include "rastro/slam/ekf/ekf_testing.h"
#include "rastro/slam/ekf/line_extraction.h"

namespace rastro {
namespace {

using testing::matrix_near;
using testing::scan_of;
using testing::WallWorld;

constexpr double pi = std::numbers::pi;
// The seam of the 360-degree scan is on a wall, not on a corner.
constexpr std::size_t beams = 721;
constexpr double full_circle = 2.0 * pi * 720.0 / 721.0;

std::vector<BodyObservation> seen(const WallWorld& world, const SE2& world_from_laser, const EkfOptions& options = {},
                                  std::uint64_t seed = 1) {
  Random random(seed);
  const LaserScan scan = scan_of(world, world_from_laser, beams, full_circle, 0.0, random);
  return scan_observations(scan, options, random);
}

const BodyObservation* nearest_to(const std::vector<BodyObservation>& observations, const Eigen::Vector2d& position) {
  const auto nearest = std::min_element(observations.begin(), observations.end(), [&](const auto& a, const auto& b) {
    return (a.in_body - position).norm() < (b.in_body - position).norm();
  });
  return nearest == observations.end() ? nullptr : &*nearest;
}

WallWorld polygon(const std::vector<Eigen::Vector2d>& corners) {
  WallWorld world;
  world.add_polygon(corners);
  return world;
}

TEST(ScanFeatures, FindEveryCornerOfExactPolygonsAtItsPosition) {
  const std::vector<std::vector<Eigen::Vector2d>> polygons = {
      {{-3.0, -2.0}, {4.0, -2.0}, {4.0, 3.0}, {-3.0, 3.0}},                           // a room
      {{-3.0, -2.0}, {5.0, -2.0}, {0.5, 5.0}},                                        // acute angles
      {{-3.0, -2.0}, {0.0, -3.5}, {4.0, -2.0}, {4.0, 3.0}, {0.0, 4.5}, {-3.0, 3.0}},  // obtuse ones
      {{-3.0, -2.0}, {4.0, -2.0}, {4.0, 3.0}, {2.0, 3.0}, {2.0, 1.5}, {-3.0, 1.5}},   // one convex corner
  };
  for (const auto& corners : polygons) {
    const SE2 world_from_laser(SO2::from_angle(0.1), {2.8, -0.2});
    const auto observations = seen(polygon(corners), world_from_laser);
    EXPECT_EQ(observations.size(), corners.size());
    for (const Eigen::Vector2d& corner : corners) {
      const Eigen::Vector2d expected = world_from_laser.inverse() * corner;
      const BodyObservation* found = nearest_to(observations, expected);
      ASSERT_NE(found, nullptr);
      EXPECT_THAT(found->in_body, matrix_near(expected, 1e-5));
      EXPECT_EQ(found->kind, LandmarkKind::corner);
    }
  }
}

TEST(ScanFeatures, ACornerHasTheDirectionBetweenItsWalls) {
  const SE2 world_from_laser(SO2(), {2.8, 0.0});
  const auto observations =
      seen(polygon({{-3.0, -2.0}, {4.0, -2.0}, {4.0, 3.0}, {2.0, 3.0}, {2.0, 1.5}, {-3.0, 1.5}}), world_from_laser);
  const auto direction_at = [&](double x, double y) {
    const BodyObservation* found = nearest_to(observations, {x - 2.8, y});
    EXPECT_THAT(found->in_body, matrix_near(Eigen::Vector2d(x - 2.8, y), 1e-5));
    return found->direction;
  };
  EXPECT_NEAR(angle_between(direction_at(4.0, -2.0), 0.75 * pi), 0.0, 1e-4);
  EXPECT_NEAR(angle_between(direction_at(-3.0, 1.5), -0.25 * pi), 0.0, 1e-4);
  // The convex one: its walls lead away from the room.
  EXPECT_NEAR(angle_between(direction_at(2.0, 1.5), 0.75 * pi), 0.0, 1e-4);
}

TEST(ScanFeatures, AreGivenInTheBodyFrame) {
  Random random(1);
  const WallWorld world = polygon({{-3.0, -2.0}, {4.0, -2.0}, {4.0, 3.0}, {-3.0, 3.0}});
  const SE2 body_from_laser(SO2::from_angle(0.4), {0.2, 0.1});
  LaserScan scan = scan_of(world, body_from_laser, beams, full_circle, 0.0, random);
  scan.body_from_laser = body_from_laser;
  const auto observations = scan_observations(scan, {}, random);
  const BodyObservation* corner = nearest_to(observations, {4.0, 3.0});
  EXPECT_THAT(corner->in_body, matrix_near(Eigen::Vector2d(4.0, 3.0), 1e-5));
  EXPECT_NEAR(angle_between(corner->direction, -0.75 * pi), 0.0, 1e-4);
}

TEST(ScanFeatures, LinesThatDoNotReachTheirIntersectionMakeNoCorner) {
  WallWorld world;  // A doorway half a meter wide at the corner.
  world.walls = {{{3.0, -3.0}, {3.0, 1.5}}, {{2.5, 2.0}, {-3.0, 2.0}}};
  EXPECT_TRUE(seen(world, {}).empty());
  world.walls = {{{3.0, -3.0}, {3.0, 2.0}}, {{3.0, 2.0}, {-3.0, 2.0}}};
  EXPECT_EQ(seen(world, {}).size(), 1U);
}

TEST(ScanFeatures, HaveConsistentCovariances) {
  EkfOptions options;
  options.beam_noise_m = 0.01;
  options.corner_error_m = 1e-4;
  options.spikes = false;
  const WallWorld world = polygon({{-3.0, -2.0}, {4.0, -2.0}, {4.0, 3.0}, {-3.0, 3.0}});
  Random random(7);
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < 300; ++i) {
    const LaserScan scan = scan_of(world, {}, 361, full_circle, options.beam_noise_m, random);
    const auto observations = scan_observations(scan, options, random);
    for (const Eigen::Vector2d& corner : {Eigen::Vector2d(4.0, 3.0), Eigen::Vector2d(-3.0, -2.0)}) {
      const BodyObservation* found = nearest_to(observations, corner);
      ASSERT_NE(found, nullptr);
      if ((found->in_body - corner).norm() > 0.2) continue;
      sum += squared_mahalanobis(found->in_body - corner, found->covariance);
      ++count;
    }
  }
  EXPECT_GE(count, 590);
  // 2 for pure noise, within 95 % of chi-square with 1200 degrees of freedom: 1.84 to 2.16. The remainder is the
  // assignment of points near the corner to the two lines.
  EXPECT_NEAR(sum / count, 2.0, 0.4);
}

TEST(ScanFeatures, FindAPoleFromAllSidesAtItsCenter) {
  WallWorld world = polygon({{-6.0, -6.0}, {6.0, -6.0}, {6.0, 6.0}, {-6.0, 6.0}});
  world.poles = {{{0.5, 0.3}, 0.06}};
  EkfOptions options;
  options.corners = false;
  for (int i = 0; i < 16; ++i) {
    const SO2 side = SO2::from_angle(0.4 * i);
    const SE2 world_from_laser(side * SO2::from_angle(pi), world.poles[0].middle + side * Eigen::Vector2d(2.5, 0.0));
    const auto observations = seen(world, world_from_laser, options);
    ASSERT_EQ(observations.size(), 1U);
    EXPECT_EQ(observations[0].kind, LandmarkKind::spike);
    EXPECT_LT((world_from_laser * observations[0].in_body - world.poles[0].middle).norm(), 0.02);
  }
}

TEST(ScanFeatures, APoleNeedsAFarBackgroundOnBothSides) {
  EkfOptions options;
  options.corners = false;
  WallWorld near_wall = polygon({{-6.0, -6.0}, {6.0, -6.0}, {6.0, 6.0}, {-6.0, 6.0}});
  near_wall.poles = {{{5.7, 0.0}, 0.06}};
  EXPECT_TRUE(seen(near_wall, {}, options).empty());

  WallWorld free;
  free.poles = {{{3.0, 0.0}, 0.06}};
  EXPECT_EQ(seen(free, {}, options).size(), 1U);
  Random random(1);
  LaserScan scan = scan_of(free, {}, beams, full_circle, 0.0, random);
  const auto first = static_cast<std::size_t>(
      std::find_if(scan.ranges.begin(), scan.ranges.end(), [](float range) { return range < 4.0F; }) -
      scan.ranges.begin());
  scan.ranges[first - 1] = std::numeric_limits<float>::quiet_NaN();  // The range beside it is unknown.
  EXPECT_TRUE(scan_observations(scan, options, random).empty());
}

TEST(ScanFeatures, BrokenScansGiveNothing) {
  Random random(1);
  LaserScan scan;
  EXPECT_TRUE(scan_observations(scan, {}, random).empty());
  scan.max_range = 80.0;
  scan.angle_step = 0.01;
  for (const float range :
       {0.0F, -1.0F, 1e30F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    scan.ranges.assign(300, range);
    EXPECT_TRUE(scan_observations(scan, {}, random).empty());
  }
  for (const double step : {0.0, std::numeric_limits<double>::quiet_NaN(), 1e300}) {
    scan.angle_step = step;
    for (std::size_t beam = 0; beam < 300; ++beam)
      scan.ranges[beam] = static_cast<float>(1.0 + 0.05 * random.uniform());
    for (const BodyObservation& observation : scan_observations(scan, {}, random))
      EXPECT_TRUE(observation.in_body.allFinite());
  }
}

TEST(ScanFeatures, OfExactWallsDoNotDependOnTheSeed) {
  const WallWorld world = polygon({{-3.0, -2.0}, {4.0, -2.0}, {4.0, 3.0}, {-3.0, 3.0}});
  const auto one = seen(world, {}, {}, 1), other = seen(world, {}, {}, 99);
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_THAT(one[i].in_body, matrix_near(other[i].in_body, 1e-5));
}

TEST(LineFit, HasACovarianceThatPredictsItsError) {
  // Repeated scans of a wall 2 m ahead: offset and rotation scatter as the fit predicts.
  Random random(3);
  EkfOptions options;
  const double noise = options.beam_noise_m = 0.01;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero(), said = Eigen::Matrix2d::Zero();
  constexpr int rounds = 2000;
  for (int i = 0; i < rounds; ++i) {
    std::vector<ScanPoint> run;
    for (int beam = -20; beam <= 60; ++beam) {
      const double angle = beam * 0.01, range = 2.0 / std::cos(angle) + noise * random.normal();
      run.push_back({{range * std::cos(angle), range * std::sin(angle)}, range, 0});
    }
    const ScanLine line = fit_line(run, 0, run.size() - 1, options);
    const Eigen::Vector2d off(2.0 - line.center.x(), std::atan2(-line.direction.x(), line.direction.y()));
    scatter += off * off.transpose() / rounds;
    said += line.covariance / rounds;
  }
  EXPECT_NEAR(scatter(0, 0) / said(0, 0), 1.0, 0.1);
  EXPECT_NEAR(scatter(1, 1) / said(1, 1), 1.0, 0.1);
}

}  // namespace
}  // namespace rastro
