// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/input_monitor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <string>
#include <utility>

#include "rastro/registration/walls_testing.h"
#include "rastro/synthetic/worlds/loop.h"
#include "rastro/synthetic/worlds/rooms.h"

namespace rastro {
namespace {

using Disturb = std::function<void(Frame&)>;

/// The kinds that are told, joined.
std::string told(const SourceInfo& info, const std::vector<Frame>& frames, const Disturb& disturb = {}) {
  InputMonitor monitor(info);
  for (Frame frame : frames) {
    if (disturb) disturb(frame);
    monitor.add(frame);
  }
  std::string kinds;
  for (const InputWarning& warning : monitor.warnings()) kinds += (kinds.empty() ? "" : " ") + warning.kind;
  return kinds;
}

// Laser and odometry.

/// Twice around a room with a pillar, with wheels that count 4 % too much.
std::vector<Frame> laser_drive() {
  testing::Walls walls;
  walls.add_box(-2.0, -2.5, 7.0, 5.0);
  walls.add_box(2.0, 1.0, 3.0, 2.2);
  std::vector<Frame> frames;
  SE2 world_from_body, odometry;
  for (int k = 0; k < 240; ++k) {
    const SE2::Tangent motion(0.08, 0.0, k % 60 >= 40 ? 0.0785 : 0.0);
    world_from_body = world_from_body * SE2::exp(motion);
    odometry = odometry * SE2::exp(1.04 * motion);
    Frame& frame = frames.emplace_back();
    frame.index = k;
    frame.stamp = k * from_seconds(0.1);
    frame.odometry_from_body = odometry;
    LaserScan scan;
    scan.first_angle = -2.3;
    scan.angle_step = 4.6 / 270;
    scan.max_range = 15.0;
    for (int beam = 0; beam <= 270; ++beam) {
      const double angle = scan.angle_of(static_cast<std::size_t>(beam));
      const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
      scan.ranges.push_back(static_cast<float>(
          std::min(16.0, walls.range(world_from_body.translation(), world_from_body.rotation() * direction))));
    }
    frame.scan = scan;
  }
  return frames;
}

TEST(InputMonitor, SaysNothingAboutARightLaser) { EXPECT_EQ(told({}, laser_drive()), ""); }

TEST(InputMonitor, TellsMirroredBeams) {
  EXPECT_EQ(
      told({}, laser_drive(), [](Frame& frame) { std::reverse(frame.scan->ranges.begin(), frame.scan->ranges.end()); }),
      "laser_mirrored");
}

TEST(InputMonitor, TellsScaledRanges) {
  for (const float factor : {0.5F, 2.0F}) {
    EXPECT_EQ(told({}, laser_drive(),
                   [factor](Frame& frame) {
                     for (float& range : frame.scan->ranges) range *= factor;
                     frame.scan->max_range *= static_cast<double>(factor);
                   }),
              "laser_scale");
  }
}

TEST(InputMonitor, TellsOdometryOfTheWrongSign) {
  SE2 last, reversed;
  EXPECT_EQ(told({}, laser_drive(),
                 [&](Frame& frame) {
                   const SE2 motion = last.inverse() * *frame.odometry_from_body;
                   last = *frame.odometry_from_body;
                   reversed = reversed * SE2::exp(-motion.log());
                   frame.odometry_from_body = reversed;
                 }),
            "odometry_reversed");
}

TEST(InputMonitor, TellsAStuckLaserOnlyWhileTheWheelsMove) {
  const std::vector<Frame> drive = laser_drive();
  const auto stick = [&](Frame& frame) { frame.scan->ranges = drive[50].scan->ranges; };
  EXPECT_EQ(told({}, drive, [&](Frame& frame) { frame.index >= 50 ? stick(frame) : void(); }), "laser_stuck");
  EXPECT_EQ(told({}, drive,
                 [&](Frame& frame) {
                   stick(frame);
                   frame.odometry_from_body = SE2();
                 }),
            "");
}

TEST(InputMonitor, TellsOdometryThatStaysWhileTheScansMove) {
  const std::vector<Frame> drive = laser_drive();
  const auto freeze = [&](Frame& frame, int from, int to) {
    if (frame.index >= from && frame.index < to)
      frame.odometry_from_body = drive[static_cast<std::size_t>(from)].odometry_from_body;
  };
  EXPECT_EQ(told({}, drive, [&](Frame& frame) { freeze(frame, 50, 90); }), "odometry_stuck");
  EXPECT_EQ(told({}, drive, [&](Frame& frame) { freeze(frame, 50, 60); }), "") << "a second";
  EXPECT_EQ(told({}, drive,
                 [&](Frame& frame) {  // at rest
                   freeze(frame, 50, 90);
                   if (frame.index >= 50 && frame.index < 90) frame.scan = drive[frame.index % 2 ? 50U : 51U].scan;
                 }),
            "");
}

TEST(InputMonitor, TellsUnitsThatAreNotMeters) {
  EXPECT_EQ(told({}, laser_drive(),
                 [](Frame& frame) {
                   for (float& range : frame.scan->ranges) range *= 1000.0F;
                   frame.scan->max_range *= 1000.0;
                 }),
            "laser_unit");
  EXPECT_EQ(told({}, laser_drive(),
                 [](Frame& frame) {
                   const SE2& pose = *frame.odometry_from_body;
                   frame.odometry_from_body = SE2(pose.rotation(), 100.0 * pose.translation());
                 }),
            "odometry_unit");
}

// Cameras.

struct Recorded {
  SourceInfo info;
  std::vector<Frame> frames;
};

Recorded record(const World& world, std::int64_t frames, bool stereo) {
  const auto source = synthetic_source(world, frames, 2, stereo);
  Recorded recorded{source->info(), {}};
  while (auto frame = source->next()) {
    if (stereo) frame->depth = {};
    recorded.frames.push_back(std::move(*frame));
  }
  return recorded;
}

const Recorded& pair_recording() {
  static const Recorded recorded = record(make_loop({.scale = 0.75}), 36, true);
  return recorded;
}

TEST(InputMonitorStereo, SaysNothingAboutARightPair) {
  EXPECT_EQ(told(pair_recording().info, pair_recording().frames), "");
}

TEST(InputMonitorStereo, TellsASwappedPair) {
  EXPECT_EQ(told(pair_recording().info, pair_recording().frames, [](Frame& frame) { frame.image.swap(frame.right); }),
            "stereo_swapped");
}

TEST(InputMonitorStereo, TellsAnImpossibleBaseline) {
  SourceInfo info = pair_recording().info;
  info.left_from_right = SE3(info.left_from_right->rotation(), 10.0 * info.left_from_right->translation());
  EXPECT_EQ(told(info, pair_recording().frames), "baseline");
}

TEST(InputMonitorStereo, TellsTheFocalLengthOfAnotherCamera) {
  const Recorded recorded = record(make_loop({.scale = 0.5}), 120, true);
  for (const double factor : {0.75, 1.0, 1.3}) {
    SourceInfo info = recorded.info;
    for (auto& each : info.cameras) {
      each.camera->fx *= factor;
      each.camera->fy *= factor;
    }
    EXPECT_EQ(told(info, recorded.frames), factor == 1.0 ? "" : "focal_length") << factor;
  }
}

TEST(InputMonitorStereo, TellsRowsThatDoNotAgree) {
  const auto lower = [](Frame& frame) {
    constexpr int rows = 6;
    for (int y = frame.right.height() - 1; y >= rows; --y)
      std::copy_n(frame.right.row(y - rows), frame.right.width(), frame.right.row(y));
  };
  EXPECT_EQ(told(pair_recording().info, pair_recording().frames, lower), "stereo_not_rectified");
}

TEST(InputMonitorStereo, TheSameWarningsTwice) {
  InputMonitor first(pair_recording().info), second(pair_recording().info);
  for (Frame frame : pair_recording().frames) {
    frame.image.swap(frame.right);
    first.add(frame);
    second.add(frame);
  }
  ASSERT_EQ(first.warnings().size(), 1U);
  EXPECT_EQ(first.warnings().front().text, second.warnings().front().text);
}

const Recorded& room_recording() {
  static const Recorded recorded = record(make_bedroom(), 75, false);
  return recorded;
}

TEST(InputMonitorDepth, SaysNothingAboutRightDepth) {
  EXPECT_EQ(told(room_recording().info, room_recording().frames), "");
}

TEST(InputMonitorDepth, TellsMirroredDepth) {
  EXPECT_EQ(told(room_recording().info, room_recording().frames,
                 [](Frame& frame) {
                   for (int y = 0; y < frame.depth.height(); ++y)
                     std::reverse(frame.depth.row(y), frame.depth.row(y) + frame.depth.width());
                 }),
            "depth_mirrored");
}

TEST(InputMonitorDepth, TellsConstantDepth) {
  EXPECT_EQ(told(room_recording().info, room_recording().frames,
                 [](Frame& frame) {
                   for (int y = 0; y < frame.depth.height(); ++y)
                     std::fill_n(frame.depth.row(y), frame.depth.width(), 2.0F);
                 }),
            "depth_constant");
}

TEST(InputMonitorDepth, TellsEmptyDepth) {
  EXPECT_EQ(told(room_recording().info, room_recording().frames,
                 [](Frame& frame) {
                   for (int y = 0; y < frame.depth.height(); ++y)
                     std::fill_n(frame.depth.row(y), frame.depth.width(), 0.0F);
                 }),
            "depth_empty");
}

TEST(InputMonitorDepth, TellsTheFocalLengthOfAnotherCamera) {
  const Recorded recorded = record(make_bedroom({.scale = 0.5}), 180, false);
  for (const double factor : {0.75, 1.0, 1.3}) {
    SourceInfo info = recorded.info;
    info.cameras.front().camera->fx *= factor;
    info.cameras.front().camera->fy *= factor;
    EXPECT_EQ(told(info, recorded.frames), factor == 1.0 ? "" : "focal_length") << factor;
  }
}

TEST(InputMonitorDepth, TellsStampsThatGoBackAndNotRepeatedOnes) {
  EXPECT_EQ(told(room_recording().info, room_recording().frames,
                 [](Frame& frame) {
                   if (frame.index == 7) frame.stamp -= from_seconds(0.5);
                 }),
            "stamps_backward");
  EXPECT_EQ(told({}, {{.stamp = 1}, {.index = 1, .stamp = 1}, {.index = 2, .stamp = 2}}), "");
}

TEST(InputMonitorDepth, TellsDepthOfAnEarlierMoment) {
  std::deque<DepthImage> before;
  EXPECT_EQ(told(room_recording().info, room_recording().frames,
                 [&](Frame& frame) {
                   before.push_back(frame.depth);
                   if (before.size() > 4) before.pop_front();
                   frame.depth = before.front();
                 }),
            "depth_late");
}

TEST(InputMonitorDepth, SurvivesEmptyAndStrangeFrames) {
  InputMonitor monitor(room_recording().info);
  for (int k = 0; k < 20; ++k) {
    Frame frame;
    frame.index = k;
    if (k % 3 > 0) frame.image = GrayImage(k % 5 == 0 ? 5 : 64, 48);
    if (k % 2 > 0) frame.depth = DepthImage(7, 9);
    frame.right = GrayImage(11 + k, 3);
    monitor.add(frame);
  }
  EXPECT_TRUE(monitor.warnings().empty());
}

}  // namespace
}  // namespace rastro
