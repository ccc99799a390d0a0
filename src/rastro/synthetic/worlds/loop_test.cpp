// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/loop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/synthetic/worlds/loop_scene.h"
#include "rastro/synthetic/worlds/loop_walk.h"
#include "rastro/synthetic/write_loop_closures.h"

namespace rastro {
namespace {

const World& small_loop() {
  static const World world = make_loop({.scale = 0.15, .threads = 2});
  return world;
}

bool is_elsewhere(std::int64_t frame) { return frame >= loop_elsewhere_begin && frame < loop_elsewhere_end; }

TEST(LoopWalk, is_120_m_long_and_returns_to_its_start_after_a_round) {
  EXPECT_NEAR(loop::path_m(), 120.0, 0.1);
  const double speed_per_frame = loop::speed / loop::rate_hz;
  const auto walking = static_cast<double>(loop_frames - (loop_elsewhere_end - loop_elsewhere_begin));
  EXPECT_NEAR(walking * speed_per_frame, loop::path_m(), 0.5);
  const loop::PathPoint start = loop::path_point(0.0), back = loop::path_point(loop::round_m() + 2.2);
  EXPECT_NEAR((back.position - loop::path_point(2.2).position).norm(), 0.0, 1e-6);
  EXPECT_NEAR(back.heading - start.heading, 2.0 * std::numbers::pi, 1e-9);
  for (double distance = 0.0; distance < loop::path_m() - 0.1; distance += 0.07) {
    const loop::PathPoint a = loop::path_point(distance), b = loop::path_point(distance + 0.05);
    ASSERT_NEAR((b.position - a.position).norm(), 0.05, 1e-3) << distance;
    ASSERT_LT(std::abs(b.heading - a.heading), 0.03) << distance;
  }
}

TEST(LoopTest, has_no_collision_and_shows_another_place_for_two_seconds) {
  const World& world = small_loop();
  for (std::int64_t frame = 0; frame < loop_frames; ++frame) {
    const SE3 here = world.world_from_camera(frame), next = world.world_from_camera(frame + 1);
    ASSERT_FALSE(world.scene_at(frame).touches(here.translation(), 0.4)) << "frame " << frame;
    const double step = (next.translation() - here.translation()).norm();
    if (is_elsewhere(frame) != is_elsewhere(frame + 1)) {
      ASSERT_GT(step, 40.0) << frame;
    } else {
      ASSERT_LT(step, 0.11) << frame;
      ASSERT_LT((here.inverse() * next).rotation().log().norm(), 0.085) << frame;
    }
  }
  // The walk continues where it was.
  const SE3 before = world.world_from_camera(loop_elsewhere_begin - 1),
            after = world.world_from_camera(loop_elsewhere_end);
  EXPECT_LT((before.inverse() * after).translation().norm(), 0.11);
}

TEST(LoopTest, closes_once_in_the_same_direction_and_once_against_it) {
  int same = 0, opposite = 0;
  TaskPool pool(2);
  for (const TrueLoopClosure& loop_closure : true_loop_closures(small_loop(), loop_frames, {}, pool)) {
    SCOPED_TRACE(loop_closure.frame);
    EXPECT_FALSE(is_elsewhere(loop_closure.frame) || is_elsewhere(loop_closure.earlier));
    const bool at_start = loop_closure.frame >= 860 && loop_closure.frame <= 1010 && loop_closure.earlier <= 100;
    const bool in_the_square = loop_closure.frame >= 1400 && loop_closure.earlier >= 650 && loop_closure.earlier <= 800;
    EXPECT_TRUE(at_start || in_the_square) << loop_closure.earlier;
    if (at_start) {
      EXPECT_FALSE(loop_closure.opposite);
    }
    same += at_start ? 1 : 0;
    opposite += in_the_square && loop_closure.opposite ? 1 : 0;
  }
  EXPECT_GE(same, 8);
  EXPECT_GE(opposite, 5);
}

TEST(LoopTest, people_are_in_front_of_the_camera_where_the_crowd_is_and_nowhere_else) {
  const World& world = small_loop();
  TaskPool pool(2);
  const auto moving_share = [&](std::int64_t frame) {
    const Image<std::uint32_t> surface = world.render(frame, pool).surface;
    int moving = 0;
    for (int y = 0; y < surface.height(); ++y)
      for (int x = 0; x < surface.width(); ++x)
        if (surface.at(x, y) != no_surface)
          moving += world.scene().surfaces()[surface.at(x, y)].primitive >= world.scene().still_count() ? 1 : 0;
    return static_cast<double>(moving) / (surface.width() * surface.height());
  };
  double most = 0.0, sum = 0.0;
  int count = 0;
  for (std::int64_t frame = loop_crowd_begin; frame < loop_crowd_end; frame += 15, ++count) {
    const double share = moving_share(frame);
    most = std::max(most, share), sum += share;
  }
  EXPECT_GT(sum / count, 0.02);
  EXPECT_GT(most, 0.06);
  for (const std::int64_t frame : {450, 520, 560, 700, 800, 950, 1100, 1300, 1500})
    EXPECT_LT(moving_share(frame), 0.003) << frame;
}

/// Geometry of a rectified pair: a point in a row of the left image is in the same row of the right one, shifted to the
/// left by the disparity.
TEST(LoopTest, the_right_camera_sees_the_same_points_in_the_same_rows) {
  const World& world = small_loop();
  TaskPool pool(2);
  const Camera& camera = world.camera();
  ASSERT_TRUE(world.left_from_right());
  const double baseline = world.left_from_right()->translation().x();
  EXPECT_NEAR(baseline, 0.12, 1e-12);
  for (const std::int64_t frame : {10, 470, 1000}) {
    const RenderedFrame right = world.render_right(frame, pool);
    const Scene scene = world.scene_at(frame);
    const SE3 pose = world.world_from_camera(frame);
    int compared = 0;
    for (int y = 1; y < camera.height; y += 5)
      for (int x = 1; x < camera.width; x += 5) {
        const double depth = static_cast<double>(right.depth.at(x, y));
        const Eigen::Vector2d in_left(x + camera.fx * baseline / depth, y);
        const auto ray = camera.unproject(in_left);
        ASSERT_TRUE(ray);
        const Eigen::Vector3d point = pose * (depth * Eigen::Vector3d(ray->x(), ray->y(), 1.0));
        const PointView view = world.view_of(frame, point);
        if (!view.visible) continue;
        EXPECT_NEAR(view.pixel.y(), y, 1e-3);
        const auto hit = scene.trace(pose.translation(), point - pose.translation(), 1.001);
        if (!hit) continue;  // The rim of a solid.
        EXPECT_LT((hit->point - point).norm(), 1e-3 * depth);
        EXPECT_EQ(hit->surface, right.surface.at(x, y));
        ++compared;
      }
    EXPECT_GT(compared, 150) << frame;
  }
}

TEST(LoopTest, depth_is_that_of_the_oracle_and_the_images_have_contrast) {
  const World& world = small_loop();
  TaskPool pool(2);
  for (const std::int64_t frame : {0, 300, 500, 570, 760, 1450}) {
    const RenderedFrame shot = world.render(frame, pool);
    double sum = 0, squares = 0;
    for (int y = 0; y < shot.gray.height(); ++y)
      for (int x = 0; x < shot.gray.width(); ++x) {
        sum += shot.gray.at(x, y), squares += shot.gray.at(x, y) * shot.gray.at(x, y);
        if (x % 7 != 0 || y % 6 != 0) continue;
        const auto hit = world.surface_at(frame, {x, y});
        ASSERT_TRUE(hit) << "sky all around";
        ASSERT_EQ(static_cast<float>(hit->t), shot.depth.at(x, y)) << frame << " at " << x << ' ' << y;
      }
    const double pixels = shot.gray.width() * shot.gray.height(), mean = sum / pixels;
    EXPECT_GT(mean, 55) << frame;
    EXPECT_LT(mean, 190) << frame;
    EXPECT_GT(std::sqrt(squares / pixels - mean * mean), 22) << frame;
  }
}

TEST(LoopTest, frames_of_both_cameras_are_the_same_for_any_threads_and_differ_for_another_seed) {
  const World again = make_loop({.scale = 0.15, .threads = 1}), other = make_loop({.seed = 2, .scale = 0.15});
  TaskPool one(1), eight(8);
  const auto share_that_differs = [](const GrayImage& a, const GrayImage& b) {
    std::int64_t differ = 0;
    for (int y = 0; y < a.height(); ++y)
      for (int x = 0; x < a.width(); ++x) differ += a.at(x, y) != b.at(x, y) ? 1 : 0;
    return static_cast<double>(differ) / (a.width() * a.height());
  };
  for (const std::int64_t frame : {20, 330}) {
    EXPECT_EQ(share_that_differs(small_loop().render(frame, eight).gray, again.render(frame, one).gray), 0.0);
    EXPECT_EQ(share_that_differs(small_loop().render_right(frame, eight).gray, again.render_right(frame, one).gray),
              0.0);
  }
  EXPECT_GT(share_that_differs(small_loop().render(20, eight).gray, other.render(20, one).gray), 0.5);
  EXPECT_EQ(other.world_from_camera(777).translation(), again.world_from_camera(777).translation());
  EXPECT_THROW(make_loop({.scale = 100}), Error);
}

}  // namespace
}  // namespace rastro
