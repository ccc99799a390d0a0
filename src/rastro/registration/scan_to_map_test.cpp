// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/scan_to_map.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/registration/walls_testing.h"

namespace rastro {
namespace {

using testing::Walls;

constexpr double unknown = 128.0 / 255.0;

/// Grids of 5, 10 and 20 cm with the scans of `poses` in them.
class Levels {
 public:
  Levels(const Walls& walls, const std::vector<SE2>& poses, double reach_m = 20.0) {
    for (const double cell_m : {0.05, 0.1, 0.2}) {
      LogOddsGrid& grid = grids_.emplace_back(cell_m, LogOddsModel());
      for (const SE2& pose : poses) {
        std::vector<Eigen::Vector2d> placed;
        for (const Eigen::Vector2d& point : walls.returns(pose, 1440, reach_m)) placed.push_back(pose * point);
        grid.insert(pose.translation(), placed);
      }
    }
    for (const LogOddsGrid& grid : grids_) views_.push_back(grid.view());
  }
  const std::vector<ProbabilityView>& views() const { return views_; }

 private:
  std::vector<LogOddsGrid> grids_;
  std::vector<ProbabilityView> views_;
};

SE2 pose_of(double x, double y, double angle) { return {SO2::from_angle(angle), {x, y}}; }

SE2 moved(const SE2& pose, const Eigen::Vector3d& by) {
  return {pose.rotation() * SO2::from_angle(by.z()), pose.translation() + by.head<2>()};
}

/// The walls lie on the centers of the finest cells, or the raster would move the optimum by up to half a cell.
Walls l_shaped_room() {
  Walls walls;
  walls.add_polygon(
      {{-3.025, -2.025}, {4.025, -2.025}, {4.025, 0.975}, {1.025, 0.975}, {1.025, 3.975}, {-3.025, 3.975}});
  return walls;
}

std::vector<SE2> places_in_room() {
  return {pose_of(0.0, 0.0, 0.0), pose_of(2.0, -0.5, 0.3), pose_of(-1.0, 2.0, 1.0), pose_of(-1.5, -1.0, 2.0)};
}

TEST(ScanToMap, AlignsAMovedScan) {
  const Walls walls = l_shaped_room();
  const Levels levels(walls, places_in_room());
  Random random(5);
  for (int round = 0; round < 60; ++round) {
    const SE2 ground_truth = pose_of(random.uniform(-1.5, 0.5), random.uniform(-1.0, 0.5), random.uniform(-3.1, 3.1));
    const auto points = walls.returns(ground_truth, 360, 20.0);
    const double heading = random.uniform(-M_PI, M_PI), off_m = random.uniform(0.0, 0.15);
    const SE2 guess =
        moved(ground_truth, {off_m * std::cos(heading), off_m * std::sin(heading), random.uniform(-0.08, 0.08)});
    const auto fit = match_scan_to_map(levels.views(), points, guess, nullptr, {20});
    ASSERT_TRUE(fit);
    const SE2 off = ground_truth.inverse() * fit->map_from_body;
    EXPECT_LT(off.translation().norm(), 0.005) << round;
    EXPECT_LT(std::abs(off.rotation().angle()), 0.002) << round;
    EXPECT_GT(fit->score, score_of(levels.views().front(), points, guess) - 1e-9);
    EXPECT_NEAR(fit->score, score_of(levels.views().front(), points, fit->map_from_body), 1e-5);
  }
}

/// Derivative of the map at one beam's endpoint by (x, y, angle), from differences of score_of().
Eigen::Vector3d slope_at(const ProbabilityView& map, const Eigen::Vector2d& point, const SE2& pose) {
  Eigen::Vector3d slope;
  const Eigen::Vector3d steps(5e-4, 5e-4, 2e-4);
  for (int k = 0; k < 3; ++k) {
    Eigen::Vector3d step = Eigen::Vector3d::Zero();
    step[k] = steps[k];
    const std::span one(&point, 1);
    slope[k] = (score_of(map, one, moved(pose, step)) - score_of(map, one, moved(pose, -step))) / (2.0 * steps[k]);
  }
  return slope;
}

/// Endpoints at random positions about the walls, off the lines between cell centers, where the gradient is
/// discontinuous.
std::vector<Eigen::Vector2d> smooth_points(const ProbabilityView& map, const SE2& pose, Random& random) {
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector2d& end : l_shaped_room().returns(pose, 360, 20.0)) {
    const Eigen::Vector2d point = end + Eigen::Vector2d(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1));
    const Eigen::Vector2d at = (pose * point - map.origin) / map.cell_m - Eigen::Vector2d(0.5, 0.5);
    const Eigen::Vector2d share = at - Eigen::Vector2d(std::floor(at.x()), std::floor(at.y()));
    if (share.minCoeff() > 0.05 && share.maxCoeff() < 0.95) points.push_back(point);
  }
  return points;
}

TEST(ScanToMap, InformationAndStepFollowTheSlopeOfTheScore) {
  const Levels levels(l_shaped_room(), places_in_room());
  const std::span finest(levels.views().data(), 1);
  Random random(8);
  for (int round = 0; round < 10; ++round) {
    const SE2 pose = pose_of(random.uniform(-1.0, 0.5), random.uniform(-1.0, 0.5), random.uniform(-3.0, 3.0));
    const auto points = smooth_points(finest.front(), pose, random);
    ASSERT_GT(points.size(), 200U);
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    double squares = 0.0;
    for (const Eigen::Vector2d& point : points) {
      const Eigen::Vector3d slope = slope_at(finest.front(), point, pose);
      const double error = 1.0 - score_of(finest.front(), std::span(&point, 1), pose);
      information += slope * slope.transpose();
      gradient += slope * error;
      squares += error * error;
    }
    const auto still = match_scan_to_map(finest, points, pose, nullptr, {0});
    ASSERT_TRUE(still);
    EXPECT_LT((still->information - information).norm(), 0.005 * information.norm());
    EXPECT_NEAR(still->residual_variance, squares / static_cast<double>(points.size()), 1e-4);
    EXPECT_LT((still->map_from_body.translation() - pose.translation()).norm(), 1e-12);
    const Eigen::Vector3d step = information.inverse() * gradient;
    ASSERT_LT(step.head<2>().norm(), 0.1) << "the step must not be cut";
    const auto once = match_scan_to_map(finest, points, pose, nullptr, {1});
    ASSERT_TRUE(once);
    const SE2 expected = moved(pose, step);
    EXPECT_LT((once->map_from_body.translation() - expected.translation()).norm(), 0.01 * step.norm());
    EXPECT_NEAR((expected.rotation().inverse() * once->map_from_body.rotation()).angle(), 0.0, 0.01 * step.norm());
  }
}

/// A bare corridor along x whose ends are out of range, and the endpoints of a scan in its middle.
struct Corridor {
  Corridor() : scan(walls.returns(pose_of(0.0, 0.2, 0.0), 360, 4.0)) {}
  static Walls two_walls() {
    Walls walls;
    walls.add({-30.0, -1.025}, {30.0, -1.025});
    walls.add({-30.0, 1.025}, {30.0, 1.025});
    return walls;
  }
  Walls walls = two_walls();
  std::vector<Eigen::Vector2d> scan;
};

TEST(ScanToMap, ThePriorDecidesAlongABareCorridor) {
  const Corridor corridor;
  std::vector<SE2> poses;
  for (int k = -8; k <= 8; ++k) poses.push_back(pose_of(0.5 * k, 0.0, 0.0));
  const Levels levels(corridor.walls, poses, 8.0);
  ScanPrior prior;
  prior.information.diagonal() << 400.0, 0.1, 0.1;
  for (const double x : {-0.3, -0.1, 0.0, 0.2}) {
    prior.pose = pose_of(x, 0.28, 0.04);
    for (const double start : {x, x + 0.06}) {
      const auto fit = match_scan_to_map(levels.views(), corridor.scan, pose_of(start, 0.28, 0.04), &prior, {20});
      ASSERT_TRUE(fit);
      EXPECT_NEAR(fit->map_from_body.translation().x(), x, 0.01) << "the walls do not constrain it";
      EXPECT_NEAR(fit->map_from_body.translation().y(), 0.2, 0.005) << "the walls determine it, whatever the prior";
      EXPECT_NEAR(fit->map_from_body.rotation().angle(), 0.0, 0.002);
      EXPECT_LT(fit->information(0, 0), 0.02 * fit->information(1, 1));
    }
  }
}

TEST(ScanToMap, AStrongPriorPrevailsAndWrapsItsAngle) {
  const Walls walls = l_shaped_room();
  const Levels levels(walls, places_in_room());
  const SE2 ground_truth = pose_of(0.2, 0.1, M_PI - 0.01);
  ScanPrior prior;
  prior.information = 1e9 * Eigen::Matrix3d::Identity();
  prior.pose = moved(ground_truth, {0.02, 0.03, 0.04});  // Beyond pi: its angle is written as about -pi.
  const auto fit =
      match_scan_to_map(levels.views(), walls.returns(ground_truth, 360, 20.0), ground_truth, &prior, {20});
  ASSERT_TRUE(fit);
  const SE2 off = prior.pose.inverse() * fit->map_from_body;
  EXPECT_LT(off.translation().norm(), 1e-4);
  EXPECT_LT(std::abs(off.rotation().angle()), 1e-4);
}

TEST(ScanToMap, WithoutPointsOrLevelsThereIsNoFit) {
  const Levels levels(l_shaped_room(), places_in_room());
  EXPECT_FALSE(match_scan_to_map(levels.views(), {}, SE2(), nullptr, {}));
  const std::vector<Eigen::Vector2d> points{{1.0, 0.0}};
  EXPECT_FALSE(match_scan_to_map({}, points, SE2(), nullptr, {}));
  EXPECT_EQ(score_of(levels.views().front(), {}, SE2()), 0.0);
}

TEST(ScanToMap, FarOutsideTheMapTheGuessStays) {
  const Walls walls = l_shaped_room();
  const Levels levels(walls, places_in_room());
  const auto points = walls.returns(SE2(), 360, 20.0);
  for (const SE2& guess : {pose_of(500.0, -300.0, 1.0), pose_of(1e7, 1e7, 0.0), pose_of(-1e12, 0.0, 0.0)}) {
    const auto fit = match_scan_to_map(levels.views(), points, guess, nullptr, {});
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->score, unknown, 1e-4);
    EXPECT_EQ(fit->information.norm(), 0.0);
    EXPECT_EQ(fit->map_from_body.translation(), guess.translation());
    EXPECT_NEAR(fit->residual_variance, (1.0 - unknown) * (1.0 - unknown), 1e-4);
  }
}

TEST(ScanToMap, ScoreIsTheMapBetweenTheCentersOfFourCells) {
  const std::vector<std::uint8_t> cells{0, 255, 51, 102};
  const ProbabilityView map{cells.data(), 2, 2, 0.5, {10.0, 20.0}};
  const auto at = [&](double x, double y) {
    const std::vector<Eigen::Vector2d> point{{x, y}};
    return score_of(map, point, pose_of(10.0, 20.0, 0.0));
  };
  EXPECT_NEAR(at(0.25, 0.25), 0.0, 1e-5);
  EXPECT_NEAR(at(0.5, 0.25), 0.5, 1e-5);
  EXPECT_NEAR(at(0.25, 0.5), 0.1, 1e-5);
  EXPECT_NEAR(at(0.5, 0.5), (0.0 + 1.0 + 0.2 + 0.4) / 4.0, 1e-5);
  EXPECT_NEAR(at(0.1, 0.25), unknown, 1e-6) << "outside";
}

TEST(ScanToMap, TellsHowManyEndpointsLieInTheMapAndHowWellTheyAgree) {
  const Walls walls = l_shaped_room();
  const Levels levels(walls, places_in_room());
  const SE2 pose = pose_of(-0.5, 0.3, 0.7);
  std::vector<Eigen::Vector2d> points = walls.returns(pose, 360, 20.0);
  const auto all = match_scan_to_map(levels.views(), points, pose, nullptr, {0});
  ASSERT_TRUE(all);
  EXPECT_EQ(all->mapped, 360);
  EXPECT_NEAR(all->agreement, all->score, 1e-4);
  for (int k = 0; k < 240; ++k) points.emplace_back(50.0, 0.1 * k);
  const auto some = match_scan_to_map(levels.views(), points, pose, nullptr, {0});
  ASSERT_TRUE(some);
  EXPECT_EQ(some->mapped, 360);
  EXPECT_NEAR(some->agreement, all->agreement, 1e-4);
  EXPECT_NEAR(some->score, 0.6 * all->score + 0.4 * unknown, 1e-4);
  const std::vector<Eigen::Vector2d> outside(points.begin() + 360, points.end());
  const auto none = match_scan_to_map(levels.views(), outside, pose, nullptr, {0});
  ASSERT_TRUE(none);
  EXPECT_EQ(none->mapped, 0);
  EXPECT_EQ(none->agreement, 0.0);
}

TEST(ScanToMap, PointsAgreeWhereTheMapIsRatherOccupiedBesideThem) {
  const Walls walls = l_shaped_room();
  const Levels levels(walls, places_in_room());
  const SE2 pose = pose_of(0.5, -0.5, 0.4);
  std::vector<Eigen::Vector2d> points = walls.returns(pose, 360, 20.0);
  const std::size_t all = points.size();
  EXPECT_EQ(agreeing_points(levels.views().front(), points, pose).size(), all);
  EXPECT_LT(agreeing_points(levels.views().front(), points, moved(pose, {0.3, 0.3, 0.0})).size(), all / 4);
  // One in the free middle, one beyond the walls, where nothing is known, and one outside of the map.
  const std::vector<Eigen::Vector2d> others = {{0.3, 0.2}, {0.0, -2.6}, {500.0, 0.0}};
  points.insert(points.begin() + 100, others.begin(), others.end());
  const auto agreeing = agreeing_points(levels.views().front(), points, pose);
  ASSERT_EQ(agreeing.size(), all);
  EXPECT_EQ(agreeing[100], points[103]);
}

}  // namespace
}  // namespace rastro
