// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/laser_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace rastro {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

Material plain() {
  return {[](Canvas& canvas, Random&) { canvas.fill(100.0F); }, 1.0};
}

/// A room with walls at x = -4, x = 6, y = -2 and y = 3, and a column of 0.25 m at (2, 1).
Scene room() {
  Scene scene;
  scene.add_box({-4.1, 0.5, 1.0}, {0.2, 6.0, 2.0}, plain());
  scene.add_box({6.1, 0.5, 1.0}, {0.2, 6.0, 2.0}, plain());
  scene.add_box({1.0, -2.1, 1.0}, {10.4, 0.2, 2.0}, plain());
  scene.add_box({1.0, 3.1, 1.0}, {10.4, 0.2, 2.0}, plain());
  scene.add_cylinder({2.0, 1.0, 0.0}, {2.0, 1.0, 2.0}, 0.25, plain());
  scene.make_tree();
  return scene;
}

double wall_range(const Eigen::Vector2d& at, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const double along_x = c > 0 ? (6.0 - at.x()) / c : (-4.0 - at.x()) / c;
  const double along_y = s > 0 ? (3.0 - at.y()) / s : (-2.0 - at.y()) / s;
  return std::min(along_x, along_y);
}

/// Nearer intersection of a ray with the column's circle, from the angle to its center.
double column_range(const Eigen::Vector2d& at, double angle) {
  const Eigen::Vector2d offset = Eigen::Vector2d(2.0, 1.0) - at;
  const double off = angle - std::atan2(offset.y(), offset.x()), aside = offset.norm() * std::sin(off);
  if (std::cos(off) < 0.0 || std::abs(aside) > 0.25) return std::numeric_limits<double>::infinity();
  return offset.norm() * std::cos(off) - std::sqrt(0.0625 - aside * aside);
}

TEST(LaserModel, ranges_are_those_of_the_walls_and_the_column) {
  const Scene scene = room();
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(0, 0), Eigen::Vector2d(-3.3, 2.2), Eigen::Vector2d(4.7, -1.6)})
    for (double angle = 0.003; angle < 6.28; angle += 0.0171) {
      const LaserHit hit = trace_level(scene, {}, at, 0.35, angle);
      ASSERT_NEAR(hit.range, std::min(wall_range(at, angle), column_range(at, angle)), 1e-9) << angle;
      ASSERT_FALSE(hit.glass_range);
    }
}

TEST(LaserModel, a_scan_without_noise_is_exact_to_the_millimeter) {
  const Scene scene = room();
  LaserModel model;
  model.range_sigma = 0.0, model.dropout_share = 0.0, model.max_range = 5.0;
  const SE2 world_from_body(SO2::from_angle(0.7), {-1.0, 0.5});
  const SE2 world_from_laser = world_from_body * model.body_from_laser;
  const LaserScan scan = scan_level(scene, {}, model, world_from_body, Random(1));
  ASSERT_EQ(scan.ranges.size(), 541U);
  EXPECT_NEAR(scan.angle_of(540), 135.0 * degree, 1e-12);
  int free = 0;
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    const double angle = scan.angle_of(beam) + 0.7;
    const double range = std::min(wall_range(world_from_laser.translation(), angle),
                                  column_range(world_from_laser.translation(), angle));
    free += scan.is_free(beam) ? 1 : 0;
    ASSERT_EQ(scan.is_free(beam), range >= 4.9995) << beam;
    if (!scan.is_free(beam)) {
      ASSERT_NEAR(static_cast<double>(scan.ranges[beam]), range, 0.00051) << beam;
    }
  }
  EXPECT_GT(free, 20);
}

TEST(LaserModel, noise_and_dropouts_have_the_given_size) {
  const Scene scene = room();
  const LaserModel model;
  const SE2 pose(SO2(), {-1.0, 0.5});
  double sum = 0.0, squares = 0.0;
  int measured = 0, silent = 0, beams = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const LaserScan scan = scan_level(scene, {}, model, pose, Random(seed));
    for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam, ++beams) {
      const Eigen::Vector2d at = (pose * model.body_from_laser).translation();
      silent += scan.ranges[beam] == 0.0F ? 1 : 0;
      if (!scan.is_return(beam)) continue;
      const double error = static_cast<double>(scan.ranges[beam]) -
                           trace_level(scene, {}, at, model.height_m, scan.angle_of(beam)).range;
      sum += error, squares += error * error, ++measured;
    }
  }
  EXPECT_NEAR(silent, 0.015 * beams, 4.0 * std::sqrt(0.015 * beams));
  EXPECT_NEAR(sum / measured, 0.0, 4.0 * 0.01 / std::sqrt(measured));
  EXPECT_NEAR(std::sqrt(squares / measured), 0.01, 0.0002);
}

TEST(LaserModel, glass_reflects_from_the_front_and_hardly_from_the_side) {
  const Scene scene = room();
  const std::vector<GlassPane> panes = {{{3.0, -1.9}, {3.0, 2.9}}};
  const LaserHit hit = trace_level(scene, panes, {0.0, -1.0}, 0.35, 30.0 * degree);
  ASSERT_TRUE(hit.glass_range);
  EXPECT_NEAR(*hit.glass_range, 3.0 / std::cos(30.0 * degree), 1e-12);
  EXPECT_NEAR(hit.glass_slope, std::cos(30.0 * degree), 1e-12);
  EXPECT_FALSE(trace_level(scene, panes, {0.0, -1.0}, 0.35, 170.0 * degree).glass_range) << "it is behind";
  EXPECT_FALSE(trace_level(scene, panes, {0.0, 1.0}, 0.35, 0.0).glass_range) << "the column is in front of it";
  LaserModel model;
  model.beams = 3, model.first_angle = -40.0 * degree, model.angle_step = 40.0 * degree;
  model.range_sigma = 0.0, model.dropout_share = 0.0;
  const int times = 4000;
  int mirrored = 0, through = 0, lost = 0;
  for (std::uint64_t seed = 0; seed < times; ++seed) {
    const LaserScan scan = scan_level(scene, panes, model, SE2(SO2(), {0.0, -1.0}), Random(seed));
    mirrored += std::abs(scan.ranges[1] - 2.8F) < 0.001F ? 1 : 0;
    lost += scan.is_free(2) ? 1 : 0;
    through += std::abs(static_cast<double>(scan.ranges[2]) - wall_range({0.2, -1.0}, 40.0 * degree)) < 0.001 ? 1 : 0;
    ASSERT_FALSE(scan.is_free(0)) << "the wall is in front of the glass";
  }
  EXPECT_NEAR(mirrored, 0.80 * times, 120);
  EXPECT_NEAR(lost, 0.15 * times, 100);
  EXPECT_EQ(through + lost, times);
}

}  // namespace
}  // namespace rastro
