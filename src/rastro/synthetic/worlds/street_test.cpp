// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/street.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/synthetic/worlds/street_drive.h"
#include "rastro/synthetic/worlds/street_scene.h"

namespace rastro {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

const World& small_street() {
  static const World world = make_street({.scale = 0.1, .threads = 2});
  return world;
}

/// Yaw of the optical axis, from the world's x axis to the left.
double heading(const SE3& world_from_camera) {
  const Eigen::Vector3d axis = world_from_camera.rotation() * Eigen::Vector3d::UnitZ();
  return std::atan2(axis.y(), axis.x());
}

TEST(Drive, laps_close_and_have_the_driven_path_length) {
  const street::Drive drive;
  const street::PlanPose start = drive.pose_at_distance(0.0), end = drive.pose_at_distance(drive.lap_m() - 1e-9);
  EXPECT_NEAR(std::hypot(end.x - start.x, end.y - start.y), 0.0, 0.01);
  EXPECT_NEAR(std::remainder(end.heading - start.heading, 2.0 * std::numbers::pi), 0.0, 1e-3);
  for (double distance = -30.0; distance < 700.0; distance += 0.37) {
    const street::PlanPose a = drive.pose_at_distance(distance), b = drive.pose_at_distance(distance + 0.1);
    ASSERT_NEAR(std::hypot(b.x - a.x, b.y - a.y), 0.1, 2e-3) << distance;
    ASSERT_LT(std::abs(std::remainder(b.heading - a.heading, 2.0 * std::numbers::pi)), 0.02) << distance;
  }
  EXPECT_NEAR(drive.path_at(drive.lap_s() + 3.0), drive.path_at(3.0) + drive.lap_m(), 1e-6);
  EXPECT_NEAR(drive.path_at(-drive.lap_s() + 3.0), drive.path_at(3.0) - drive.lap_m(), 1e-6);
}

TEST(StreetTest, turns_a_quarter_in_the_first_50_frames_and_again_later) {
  const World& world = small_street();
  EXPECT_NEAR(heading(world.world_from_camera(0)), 0.0, 1.0 * degree);
  EXPECT_NEAR(heading(world.world_from_camera(50)), 90.0 * degree, 1.5 * degree);
  EXPECT_NEAR(heading(world.world_from_camera(200)), 90.0 * degree, 1.5 * degree);
  EXPECT_NEAR(std::abs(heading(world.world_from_camera(300))), 180.0 * degree, 1.5 * degree);
  EXPECT_NEAR(std::abs(heading(world.world_from_camera(399))), 180.0 * degree, 1.5 * degree);
}

TEST(StreetTest, drives_at_town_speed_without_collision) {
  const World& world = small_street();
  for (int frame = 0; frame < 800; ++frame) {
    const SE3 here = world.world_from_camera(frame), next = world.world_from_camera(frame + 1);
    const double speed = (next.translation() - here.translation()).norm() * world.rate_hz();
    ASSERT_GT(speed, 4.2) << frame;
    ASSERT_LT(speed, 10.0) << frame;
    ASSERT_NEAR(here.translation().z(), street::camera_height_m, 0.03) << frame;
    ASSERT_LT((here.inverse() * next).rotation().log().norm(), 4.0 * degree) << frame;
    // As wide as the car, at the height of its roof.
    ASSERT_FALSE(world.scene_at(frame).touches(here.translation(), 0.95)) << "frame " << frame;
  }
}

TEST(StreetTest, cars_drive_and_the_houses_stay) {
  const Scene& rest = small_street().scene();
  ASSERT_TRUE(rest.moves());
  const Scene now = small_street().scene_at(100), later = small_street().scene_at(101);
  int moved = 0, stayed = 0;
  for (std::size_t i = 0; i < now.primitives().size(); ++i) {
    const double step = (later.primitives()[i].center - now.primitives()[i].center).norm();
    (step > 0.0 ? moved : stayed) += 1;
    if (step > 0.0 && step < 50.0) {  // Others start again at the end of their street.
      EXPECT_NEAR(step, step > 0.9 ? 1.1 : 0.72, 0.2);
    }
  }
  EXPECT_GT(moved, 50);
  EXPECT_GT(stayed, 2000);
}

/// The image shows a moving car where the oracle says so.
TEST(StreetTest, depth_is_that_of_the_oracle_at_the_same_time) {
  TaskPool pool(2);
  const World& world = small_street();
  for (const int frame : {0, 60, 130}) {
    const RenderedFrame shot = world.render(frame, pool);
    for (int y = 3; y < shot.depth.height(); y += 7)
      for (int x = 2; x < shot.depth.width(); x += 5) {
        const auto hit = world.surface_at(frame, {x, y});
        ASSERT_TRUE(hit) << "sky all around";
        ASSERT_EQ(static_cast<float>(hit->t), shot.depth.at(x, y)) << frame << " at " << x << ' ' << y;
        ASSERT_EQ(hit->surface, shot.surface.at(x, y));
      }
  }
}

TEST(StreetTest, frames_are_the_same_for_any_threads_and_differ_for_another_seed) {
  const World again = make_street({.scale = 0.1, .threads = 1}),
              other = make_street({.seed = 2, .scale = 0.1, .threads = 2});
  TaskPool one(1), eight(8);
  const RenderedFrame a = small_street().render(70, eight), b = again.render(70, one), c = other.render(70, one);
  std::int64_t differ = 0;
  for (int y = 0; y < a.gray.height(); ++y) {
    ASSERT_EQ(0, std::memcmp(a.gray.row(y), b.gray.row(y), static_cast<std::size_t>(a.gray.width())));
    for (int x = 0; x < a.gray.width(); ++x) differ += std::abs(a.gray.at(x, y) - c.gray.at(x, y)) > 10 ? 1 : 0;
  }
  EXPECT_GT(differ, a.gray.width() * a.gray.height() / 5);
}

TEST(StreetTest, images_have_contrast_and_the_exposure_changes) {
  TaskPool pool(2);
  double least = 255.0, most = 0.0;
  for (const int frame : {0, 30, 93, 150, 230, 330}) {
    const RenderedFrame shot = small_street().render(frame, pool);
    double sum = 0, squares = 0, extreme = 0;
    const double pixels = shot.gray.width() * shot.gray.height();
    for (int y = 0; y < shot.gray.height(); ++y)
      for (int x = 0; x < shot.gray.width(); ++x) {
        const double value = shot.gray.at(x, y);
        sum += value, squares += value * value, extreme += value <= 2 || value >= 253 ? 1 : 0;
      }
    const double mean = sum / pixels;
    EXPECT_GT(mean, 60) << frame;
    EXPECT_LT(mean, 170) << frame;
    EXPECT_GT(std::sqrt(squares / pixels - mean * mean), 25) << frame;
    EXPECT_LT(extreme / pixels, 0.15) << frame;
    least = std::min(least, mean), most = std::max(most, mean);
  }
  EXPECT_GT(most - least, 15.0);
  EXPECT_THROW(make_street({.scale = 100}), Error);
}

}  // namespace
}  // namespace rastro
