// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/corridor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/synthetic/worlds/corridor_drive.h"
#include "rastro/synthetic/worlds/corridor_scene.h"

namespace rastro {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

const LaserWorld& office() {
  static const LaserWorld world = make_corridor_floor();
  return world;
}

Eigen::Vector2d person_at(const Scene& now) { return now.primitives()[now.still_count()].center.head<2>(); }

TEST(CorridorDrive, closes_its_loop_and_drives_ten_meters_of_it_again) {
  const corridor::Drive drive;
  EXPECT_GT(drive.length_m(), 75.0);
  EXPECT_LT(drive.length_m(), 90.0);
  EXPECT_LT(drive.world_from_body(0.0).log().norm(), 1e-12);
  EXPECT_LT(drive.world_from_body(drive.loop_end_s()).log().norm(), 1e-6) << "one full rotation later";
  const SE2 end = drive.world_from_body(drive.duration_s() + 1.0);
  EXPECT_NEAR((end.translation() - Eigen::Vector2d(corridor::overlap_m, 0.0)).norm(), 0.0, 1e-6);
}

TEST(CorridorDrive, has_its_length_and_keeps_its_speed_limits) {
  const corridor::Drive drive;
  const double step = 0.05;
  double length = 0.0, yaw = 0.0;
  for (double time = 0.0; time < drive.duration_s(); time += step) {
    const SE2 motion = drive.world_from_body(time).inverse() * drive.world_from_body(time + step);
    length += motion.translation().norm();
    yaw += motion.rotation().angle();
    ASSERT_LT(motion.translation().norm() / step, corridor::most_speed + 1e-6) << time;
    ASSERT_LT(std::abs(motion.rotation().angle()) / step, 40.0 * degree) << time;
    ASSERT_LT(std::abs(motion.log().y()), 2e-4) << "wheels do not slide, at " << time;
  }
  EXPECT_NEAR(length, drive.length_m(), 0.02);
  EXPECT_NEAR(yaw, 2.0 * std::numbers::pi, 1e-3);
}

TEST(Corridor, the_robot_and_the_person_touch_nothing) {
  const LaserWorld& world = office();
  for (std::int64_t scan = 0; scan < world.scan_count(); scan += 3) {
    const double time = world.time_of(scan);
    const Scene now = world.scene->at(time);
    const Eigen::Vector2d robot = world.world_from_body(time).translation();
    for (const double height : {0.3, 0.6, 1.0})
      ASSERT_FALSE(now.touches({robot.x(), robot.y(), height}, corridor::robot_radius_m)) << "scan " << scan;
    const Eigen::Vector2d person = person_at(now);
    const Eigen::Vector2d ahead = person_at(world.scene->at(time + 0.3));
    ASSERT_LT((ahead - person).norm() / 0.3, 1.4) << "scan " << scan;
  }
}

TEST(Corridor, the_person_comes_near_and_goes_away) {
  const LaserWorld& world = office();
  double nearest = 100.0, farthest = 0.0;
  for (std::int64_t scan = 0; scan < world.scan_count(); scan += 5) {
    const double time = world.time_of(scan);
    const double away = (person_at(world.scene->at(time)) - world.world_from_body(time).translation()).norm();
    nearest = std::min(nearest, away), farthest = std::max(farthest, away);
  }
  EXPECT_LT(nearest, 1.0);
  EXPECT_GT(farthest, 20.0);
}

/// The same ranges wherever the robot is: for 15 m of driving, the laser cannot observe the motion.
TEST(Corridor, the_long_corridor_has_only_two_walls) {
  const LaserWorld& world = office();
  const LaserModel& laser = world.laser;
  for (double x = 18.2; x > 3.2; x -= 0.4) {
    const SE2 at = SE2(SO2::from_angle(std::numbers::pi), {x, 8.0}) * laser.body_from_laser;
    for (int beam = 0; beam < laser.beams; ++beam) {
      const double angle = std::numbers::pi + laser.first_angle + beam * laser.angle_step;
      const double range = 1.0 / std::abs(std::sin(angle));
      const auto hit = world.scene->trace_beside(0, {at.translation().x(), at.translation().y(), laser.height_m},
                                                 {std::cos(angle), std::sin(angle), 0.0}, laser.max_range);
      if (range < laser.max_range - 1e-6) {
        ASSERT_TRUE(hit) << x << ' ' << beam;
        ASSERT_NEAR(hit->t, range, 1e-9) << x << ' ' << beam;
      } else if (range > laser.max_range + 1e-6) {
        ASSERT_FALSE(hit) << x << ' ' << beam;
      }
    }
  }
}

TEST(Corridor, ranges_at_the_start_are_those_of_the_plan) {
  const LaserWorld& world = office();
  const auto range = [&](double x, double y, double angle) {
    return trace_level(world.scene->at(0.0), world.panes, {x, y}, world.laser.height_m, angle * degree);
  };
  EXPECT_NEAR(range(1.0, 0.0, 90.0).range, corridor::inner_south, 1e-9);
  EXPECT_NEAR(range(1.0, 0.25, -90.0).range, 0.25 - corridor::outer_south, 1e-9);
  EXPECT_NEAR(range(1.0, 0.0, 60.0).range, 1.0 / std::sin(60.0 * degree), 1e-9);
  EXPECT_NEAR(range(0.0, 0.0, 0.0).range, corridor::outer_east, 1e-9) << "the corridor's end";
  EXPECT_NEAR(range(1.0, 0.0, 45.0).range, std::sqrt(2.0) * 0.9, 0.06) << "a half column protrudes there";
  const LaserHit door = range(0.1, 0.0, -90.0);
  ASSERT_TRUE(door.glass_range) << "the glass door in the south";
  EXPECT_NEAR(*door.glass_range, 1.075, 1e-9);
  EXPECT_GT(door.range, 2.0);
}

TEST(Corridor, furniture_depends_on_the_seed_and_nothing_else_does) {
  const LaserWorld other = make_corridor_floor({.seed = 2}), again = make_corridor_floor();
  const auto ranges = [](const LaserWorld& world, const Eigen::Vector2d& at) {
    std::vector<double> list;
    for (double angle = 0.01; angle < 6.28; angle += 0.02)
      list.push_back(trace_level(*world.scene, {}, at, world.laser.height_m, angle).range);
    return list;
  };
  const Eigen::Vector2d in_room(-4.0, 2.0), in_corridor(10.0, 8.0);
  EXPECT_EQ(ranges(office(), in_room), ranges(again, in_room));
  EXPECT_NE(ranges(office(), in_room), ranges(other, in_room));
  EXPECT_EQ(ranges(office(), in_corridor), ranges(other, in_corridor));
}

TEST(Corridor, the_camera_is_on_the_robot_and_its_depth_is_that_of_the_oracle) {
  const World world = make_corridor({.scale = 0.1, .threads = 2});
  TaskPool pool(2);
  const corridor::Drive drive;
  for (const std::int64_t frame : {0, 300, 900}) {
    const SE3 body = world.world_from_camera(frame) * world.body_from_camera().inverse();
    const SE2 robot = drive.world_from_body(static_cast<double>(frame) / 10.0);
    EXPECT_LT((body.translation().head<2>() - robot.translation()).norm(), 1e-9);
    EXPECT_NEAR(body.translation().z(), 0.0, 1e-9);
    const RenderedFrame shot = world.render(frame, pool);
    double sum = 0.0, squares = 0.0;
    const double pixels = shot.gray.width() * shot.gray.height();
    for (int y = 0; y < shot.depth.height(); ++y)
      for (int x = 0; x < shot.depth.width(); ++x) {
        const double gray = shot.gray.at(x, y);
        sum += gray, squares += gray * gray;
        if (x % 7 != 3 || y % 5 != 2) continue;
        const auto hit = world.surface_at(frame, {x, y});
        ASSERT_TRUE(hit) << "walls all around, at " << frame << ' ' << x << ' ' << y;
        ASSERT_EQ(static_cast<float>(hit->t), shot.depth.at(x, y));
      }
    const double mean = sum / pixels;
    EXPECT_GT(mean, 60.0) << frame;
    EXPECT_LT(mean, 200.0) << frame;
    EXPECT_GT(std::sqrt(squares / pixels - mean * mean), 15.0) << frame;
  }
  EXPECT_THROW(make_corridor({.scale = 100}), Error);
}

}  // namespace
}  // namespace rastro
