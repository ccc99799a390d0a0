// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/global_shutter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "rastro/backend/rgbd/rgbd_session.h"
#include "rastro/backend/rgbd/rgbd_testing.h"
#include "rastro/camera/calibration_file.h"
#include "rastro/camera/rolling_shutter.h"

namespace rastro {
namespace {

using testing::looking;
using testing::room_frame;

const Eigen::Vector3d fast_turn(0.4, 1.5, -0.3);  // rad/s
constexpr double wall_distance_m = 2.0;

Camera kinect(double readout_s = 0.026) {
  Camera camera = *published_tum_camera("freiburg1");
  camera.readout_s = readout_s;
  return camera;
}

double shade_of_wall(const Eigen::Vector2d& pixel) {
  return 128.0 + 60.0 * std::sin(pixel.x() / 9.0) + 40.0 * std::cos(pixel.y() / 11.0);
}

/// A wall that faces the camera at the instant of the middle row.
Frame rolling_wall(const Camera& camera) {
  Frame frame;
  frame.image = GrayImage(camera.width, camera.height);
  frame.color.rgb = Image<std::uint8_t>(3 * camera.width, camera.height);
  frame.depth = DepthImage(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const PixelAtMiddleRow middle = at_middle_row(camera, {x, y}, -fast_turn);
      frame.image.at(x, y) = static_cast<std::uint8_t>(std::lround(shade_of_wall(middle.pixel)));
      frame.color.rgb.at(3 * x + 1, y) = frame.image.at(x, y);
      frame.depth.at(x, y) = static_cast<float>(wall_distance_m / middle.depth_factor);
    }
  }
  return frame;
}

struct Difference {
  double shade = 0.0, depth_m = 0.0;  ///< The largest.
  int masked = 0;
};

Difference from_truth(const Frame& frame) {
  Difference difference;
  for (int y = 0; y < frame.image.height(); ++y) {
    for (int x = 0; x < frame.image.width(); ++x) {
      if (!frame.mask.empty() && frame.mask.at(x, y) == 0) {
        EXPECT_EQ(frame.depth.at(x, y), 0.0F);
        ++difference.masked;
        continue;
      }
      difference.shade = std::max(difference.shade, std::abs(frame.image.at(x, y) - shade_of_wall({x, y})));
      EXPECT_EQ(frame.color.rgb.at(3 * x + 1, y), frame.image.at(x, y));
      difference.depth_m =
          std::max(difference.depth_m, std::abs(static_cast<double>(frame.depth.at(x, y)) - wall_distance_m));
    }
  }
  return difference;
}

TEST(GlobalShutter, ImageColorAndDepthAreThoseOfTheMiddleRow) {
  const Frame recorded = rolling_wall(kinect());
  const Difference before = from_truth(recorded), after = from_truth(by_global_shutter(recorded, kinect(), fast_turn));
  EXPECT_GT(before.shade, 30.0);
  EXPECT_LT(after.shade, 4.0) << "half a pixel at the border";
  EXPECT_GT(before.depth_m, 0.01);
  EXPECT_LT(after.depth_m, 1e-3) << "of the nearest pixel";
  EXPECT_GT(after.masked, 1000) << "came from outside";
  EXPECT_LT(after.masked, 640 * 480 / 20);
}

TEST(GlobalShutter, AMaskMovesWithTheImage) {
  Frame recorded = rolling_wall(kinect());
  recorded.mask = GrayImage(640, 480);
  recorded.mask.at(300, 20) = 255;
  const Frame moved = by_global_shutter(recorded, kinect(), fast_turn);
  const Eigen::Vector2d there = at_middle_row(kinect(), {300, 20}, -fast_turn).pixel;
  int allowed = 0;
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      if (moved.mask.at(x, y) == 0) continue;
      ++allowed;
      EXPECT_LT((there - Eigen::Vector2d(x, y)).norm(), 1.5);
    }
  }
  EXPECT_GE(allowed, 1);
}

TEST(GlobalShutter, WhatIsOffByLessThanHalfAPixelStays) {
  const Frame recorded = rolling_wall(kinect());
  const auto stays = [&](const Camera& camera, const Eigen::Vector3d& camera_rotation) {
    const Frame same = by_global_shutter(recorded, camera, camera_rotation);
    return same.mask.empty() && same.image.at(20, 20) == recorded.image.at(20, 20) &&
           same.depth.at(20, 20) == recorded.depth.at(20, 20);
  };
  EXPECT_TRUE(stays(kinect(0.0), fast_turn));
  EXPECT_TRUE(stays(kinect(), 0.01 * fast_turn));
  EXPECT_FALSE(stays(kinect(), fast_turn));
  Camera without_size = kinect();
  without_size.width = without_size.height = 0;
  EXPECT_TRUE(stays(without_size, fast_turn));
}

constexpr double shutter_s = 0.03, rad_per_s = 1.2;
constexpr int turn_at = 10;  ///< Frame at which the camera turns back.

/// By a camera that only turns, there and back.
SE3 turned(double seconds) {
  constexpr double turn_s = turn_at / 30.0;
  return looking({-0.5, -0.2, 1.2}, -0.3 + rad_per_s * (turn_s - std::abs(seconds - turn_s)), -0.3);
}

Frame rolling_room(int k) {
  Frame frame = room_frame(turned(k / 30.0), k);
  const Camera camera = test_room::camera();
  for (int y = 0; y < camera.height; ++y) {
    const SE3 view = turned(k / 30.0 + (y / (camera.height - 1.0) - 0.5) * shutter_s);
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d along =
          view.rotation() * Eigen::Vector3d((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1.0);
      const test_room::Hit hit = test_room::trace(view.translation(), along);
      const auto color = test_room::color_at(view.translation() + hit.distance * along, hit.face);
      std::copy(color.begin(), color.end(), frame.color.rgb.row(y) + 3 * x);
      frame.depth.at(x, y) = static_cast<float>(hit.distance);
    }
  }
  frame.image = gray_from_color(frame.color);
  return frame;
}

/// Mean distance between keyframes of a pan and of the pan back, by their matches; the camera stayed at one place.
double error_with(double known_readout_s, const std::vector<Frame>& frames) {
  RgbdSlamOptions options;
  options.keyframe_frames = 2;
  options.backend_delay_frames = 2;
  Camera camera = test_room::camera();
  camera.readout_s = known_readout_s;
  RgbdSession session(options, camera, {});
  for (const Frame& frame : frames) session.process(frame);
  session.finish();
  const auto map = session.snapshot();
  double sum_m = 0.0;
  int matches = 0;
  for (const Constraint& edge : map->constraints) {
    const auto frame_of = [&](KeyframeId id) { return map->keyframes[static_cast<std::size_t>(id)].frame; };
    if (edge.kind == ConstraintKind::odometry || frame_of(edge.from) > turn_at || frame_of(edge.to) <= turn_at)
      continue;
    sum_m += edge.rigid().translation().norm();
    ++matches;
  }
  EXPECT_GT(matches, 5);
  return sum_m / std::max(1, matches);
}

/// The pan and the pan back shear images in opposite directions.
TEST(GlobalShutter, KeyframesOfACameraThatTurnsBackFitTogether) {
  std::vector<Frame> frames;
  for (int k = 0; k < 2 * turn_at; ++k) frames.push_back(rolling_room(k));
  const double without_m = error_with(0.0, frames), with_m = error_with(shutter_s, frames);
  EXPECT_LT(with_m, 0.01);
  EXPECT_GT(without_m, 2.0 * with_m);
}

}  // namespace
}  // namespace rastro
