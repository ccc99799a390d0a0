// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/line_extraction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "rastro/slam/ekf/motion_model.h"

namespace rastro {
namespace {

constexpr double degrees = std::numbers::pi / 180.0;

/// 181 beams from -90 to 90 degrees, without returns.
LaserScan empty_scan() {
  LaserScan scan;
  scan.first_angle = -90.0 * degrees;
  scan.angle_step = degrees;
  scan.min_range = 0.05;
  scan.max_range = 30.0;
  scan.ranges.assign(181, std::numeric_limits<float>::infinity());
  return scan;
}

/// Where the beam intersects the line normal . p = distance.
double range_to(const Eigen::Vector2d& normal, double distance, double angle) {
  return distance / normal.dot(Eigen::Vector2d(std::cos(angle), std::sin(angle)));
}

LaserScan wall_scan(double distance, double tilt_rad, double noise_m = 0.0, std::uint64_t seed = 1) {
  Random random(seed);
  LaserScan scan = empty_scan();
  const Eigen::Vector2d normal(std::cos(tilt_rad), std::sin(tilt_rad));
  for (std::size_t beam = 50; beam <= 130; ++beam)
    scan.ranges[beam] = static_cast<float>(range_to(normal, distance, scan.angle_of(beam)) + noise_m * random.normal());
  return scan;
}

TEST(RunsOf, AreSplitBetweenDistantNeighbors) {
  LaserScan scan = empty_scan();
  for (std::size_t beam = 10; beam < 40; ++beam) scan.ranges[beam] = 2.0F;
  for (std::size_t beam = 40; beam < 60; ++beam) scan.ranges[beam] = 5.0F;
  for (std::size_t beam = 100; beam < 110; ++beam) scan.ranges[beam] = 3.0F;
  const auto runs = runs_of(scan, {});
  ASSERT_EQ(runs.size(), 3U);
  const std::size_t first[] = {10, 40, 100}, count[] = {30, 20, 10};
  for (std::size_t k = 0; k < 3; ++k) {
    ASSERT_EQ(runs[k].size(), count[k]);
    for (std::size_t i = 0; i < count[k]; ++i) {
      const ScanPoint& point = runs[k][i];
      EXPECT_EQ(point.beam, first[k] + i);
      EXPECT_NEAR(point.position.norm(), point.range, 1e-9);
      EXPECT_NEAR(std::atan2(point.position.y(), point.position.x()), scan.angle_of(point.beam), 1e-9);
    }
  }
}

TEST(RunsOf, LeaveOutMissingAndDistantReturns) {
  LaserScan scan = empty_scan();
  EkfOptions options;
  options.max_beam_m = 8.0;
  const float bad[] = {0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                       8.5F, 40.0F};
  for (std::size_t k = 0; k < std::size(bad); ++k) scan.ranges[30 * k] = bad[k];
  EXPECT_TRUE(runs_of(scan, options).empty());
  scan.ranges[3] = 7.9F;
  ASSERT_EQ(runs_of(scan, options).size(), 1U);
}

TEST(FitLine, LiesOnTheWallForAnyDirection) {
  for (const double tilt : {0.0, 0.4, -0.7}) {
    const auto runs = runs_of(wall_scan(2.0, tilt), {});
    ASSERT_EQ(runs.size(), 1U);
    const ScanLine line = fit_line(runs[0], 0, runs[0].size() - 1, {});
    const Eigen::Vector2d normal(std::cos(tilt), std::sin(tilt));
    EXPECT_NEAR(normal.dot(line.center), 2.0, 1e-5);
    EXPECT_NEAR(normal.dot(line.direction), 0.0, 1e-6);
    EXPECT_GT(line.direction.dot(runs[0].back().position - runs[0].front().position), 0.0) << "from first to last";
    EXPECT_NEAR(line.distance(line.center + 0.3 * line.normal() + 5.0 * line.direction), 0.3, 1e-12);
  }
}

/// Offset and rotation of lines fitted to many noisy scans of one wall scatter as the covariance predicts.
TEST(FitLine, CovarianceIsThatOfManyScans) {
  EkfOptions options;
  options.beam_noise_m = 0.01;
  options.line_tolerance_m = 0.2;  // no noisy point is left out
  constexpr double tilt = 0.5;
  const auto exact_runs = runs_of(wall_scan(2.0, tilt), options);
  const ScanLine exact = fit_line(exact_runs[0], 0, exact_runs[0].size() - 1, options);
  Eigen::Matrix2d drawn = Eigen::Matrix2d::Zero();
  constexpr int draws = 2000;
  for (int k = 0; k < draws; ++k) {
    const auto runs = runs_of(wall_scan(2.0, tilt, 0.01, static_cast<std::uint64_t>(k) + 5), options);
    ASSERT_EQ(runs.size(), 1U);
    const ScanLine line = fit_line(runs[0], 0, runs[0].size() - 1, options);
    const double rotation = std::asin(exact.normal().dot(line.direction));
    // At the exact line's center, since the means also move along the line.
    const double offset = exact.distance(line.center) - rotation * exact.direction.dot(line.center - exact.center);
    const Eigen::Vector2d error(offset, rotation);
    drawn += error * error.transpose() / draws;
  }
  EXPECT_NEAR(exact.covariance(0, 0) / drawn(0, 0), 1.0, 0.12);
  EXPECT_NEAR(exact.covariance(1, 1) / drawn(1, 1), 1.0, 0.12);
  EXPECT_NEAR(exact.covariance(0, 1), drawn(0, 1), 0.12 * std::sqrt(drawn(0, 0) * drawn(1, 1)));
  EXPECT_EQ(exact.covariance(0, 1), exact.covariance(1, 0));
}

TEST(FitLine, SingleOutliersHaveNoInfluence) {
  auto runs = runs_of(wall_scan(2.0, 0.2), {});
  const ScanLine without = fit_line(runs[0], 0, runs[0].size() - 1, {});
  runs[0][30].position *= 0.85;  // something thin in front of the wall
  const ScanLine with = fit_line(runs[0], 0, runs[0].size() - 1, {});
  EXPECT_NEAR(with.distance(without.center), 0.0, 1e-3);
  EXPECT_NEAR(with.normal().dot(without.direction), 0.0, 1e-3);
}

/// A corner of two perpendicular walls, seen from inside.
TEST(ExtractLines, FindBothWallsOfACornerUpToTheirIntersection) {
  LaserScan scan = empty_scan();
  for (std::size_t beam = 20; beam <= 160; ++beam) {
    const double angle = scan.angle_of(beam);
    const double ahead = range_to({1.0, 0.0}, 2.0, angle), left = range_to({0.0, 1.0}, 1.5, angle);
    double range = ahead > 0.0 ? ahead : 1e9;
    if (left > 0.0) range = std::min(range, left);
    scan.ranges[beam] = static_cast<float>(range);
  }
  EkfOptions options;
  const auto runs = runs_of(scan, options);
  ASSERT_EQ(runs.size(), 1U);
  Random random(3);
  const std::vector<ScanLine> lines = extract_lines(runs[0], 20, options, random);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_NEAR(lines[0].center.x(), 2.0, 0.01);
  EXPECT_NEAR(lines[1].center.y(), 1.5, 0.01);
  EXPECT_LT(lines[0].last, lines[1].first) << "along the run, no point in both";
  const double corner_angle = std::atan2(1.5, 2.0);
  EXPECT_NEAR(scan.angle_of(runs[0][lines[0].last].beam), corner_angle, 3.0 * degrees);
  EXPECT_NEAR(scan.angle_of(runs[0][lines[1].first].beam), corner_angle, 3.0 * degrees);
}

TEST(ExtractLines, FindNoneInARoundObjectOrInTooFewBeams) {
  LaserScan scan = empty_scan();
  // A pillar of 0.3 m radius, 1.5 m ahead.
  for (std::size_t beam = 0; beam < 181; ++beam) {
    const double angle = scan.angle_of(beam), across = 1.5 * std::sin(angle);
    if (std::abs(across) < 0.3 && std::cos(angle) > 0.0)
      scan.ranges[beam] = static_cast<float>(1.5 * std::cos(angle) - std::sqrt(0.09 - across * across));
  }
  EkfOptions options;
  options.line_tolerance_m = 0.01;
  const auto runs = runs_of(scan, options);
  ASSERT_GE(runs.size(), 1U);
  Random random(4);
  for (const auto& run : runs) EXPECT_TRUE(extract_lines(run, 20, options, random).empty());
  const auto wall = runs_of(wall_scan(2.0, 0.0), options)[0];
  const auto few = static_cast<std::size_t>(options.min_line_beams) - 1;
  EXPECT_TRUE(extract_lines(std::span(wall).first(few), 20, options, random).empty());
  EXPECT_TRUE(extract_lines({}, 20, options, random).empty());
}

SE2 motion(double x, double y, double angle) { return {SO2::from_angle(angle), {x, y}}; }

/// The uncertainty does not depend on the number of steps.
TEST(MotionModel, VariancesGrowWithPathAndRotationAndNotWithSteps) {
  EkfOptions options;
  options.odometry_error_m_per_m = 0.1;
  options.odometry_error_deg_per_45_deg = 4.0;
  options.heading_error_deg_per_m = 2.0;
  const Motion whole = measured_motion(motion(1.2, 0.0, 0.0), options),
               rotation = measured_motion(motion(0, 0, -1.0), options);
  Eigen::Matrix3d of_steps = Eigen::Matrix3d::Zero(), of_rotations = of_steps;
  for (int k = 0; k < 8; ++k) {
    of_steps += measured_motion(motion(0.15, 0.0, 0.0), options).covariance;
    of_rotations += measured_motion(motion(0.0, 0.0, -0.125), options).covariance;
  }
  EXPECT_LT((whole.covariance - of_steps).norm(), 1e-12);
  EXPECT_LT((rotation.covariance - of_rotations).norm(), 1e-12);
  // One meter: 10 cm; 45 degrees: 4 degrees.
  EXPECT_NEAR(measured_motion(motion(0.6, 0.8, 0.0), options).covariance(0, 0), 0.01, 1e-12);
  EXPECT_NEAR(std::sqrt(measured_motion(motion(0.0, 0.0, 45.0 * degrees), options).covariance(2, 2)), 4.0 * degrees,
              1e-12);
  EXPECT_NEAR(std::sqrt(measured_motion(motion(1.0, 0.0, 0.0), options).covariance(2, 2)), 2.0 * degrees, 1e-12);
  EXPECT_EQ(measured_motion(SE2(), options).covariance.norm(), 0.0);
}

TEST(MotionModel, WithoutOdometryTheVelocityIsKeptForAWhile) {
  EkfOptions options;
  const SE2 last = motion(0.2, 0.02, 0.1);
  const Motion twice = carried_motion(last, 0.5, 1.0, options);
  EXPECT_LT(((last * last).log() - twice.last_from_body.log()).norm(), 1e-9);
  const Motion pause = carried_motion(last, 0.1, 60.0, options);
  EXPECT_LT((SE2::exp(5.0 * last.log()).inverse() * pause.last_from_body).log().norm(), 1e-9) << "a pause is no flight";
  EXPECT_LT(carried_motion(last, 0.0, 1.0, options).last_from_body.log().norm(), 1e-12);
  EXPECT_GT(pause.covariance(0, 0), twice.covariance(0, 0));
  EXPECT_LE(pause.covariance(2, 2), 4.0) << "more than all round cannot be unknown";
}

TEST(MotionModel, AJumpExceedsTheAllowedSpeedOrYawRate) {
  EkfOptions options;
  options.max_speed_m_per_s = 2.0;
  options.jump_m = 0.5;
  options.max_yaw_rate_deg_per_s = 90.0;
  options.jump_deg = 10.0;
  EXPECT_FALSE(is_jump(motion(1.49, 0.0, 0.0), 0.5, options));
  EXPECT_TRUE(is_jump(motion(1.51, 0.0, 0.0), 0.5, options));
  EXPECT_FALSE(is_jump(motion(0.0, 0.0, 54.9 * degrees), 0.5, options));
  EXPECT_TRUE(is_jump(motion(0.0, 0.0, -55.1 * degrees), 0.5, options));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(is_jump(motion(nan, 0.0, 0.0), 0.5, options));
  EXPECT_TRUE(is_jump(motion(std::numeric_limits<double>::infinity(), 0.0, 0.0), 0.5, options));
  EXPECT_TRUE(is_jump(motion(0.1, 0.0, 0.0), nan, options));
}

}  // namespace
}  // namespace rastro
