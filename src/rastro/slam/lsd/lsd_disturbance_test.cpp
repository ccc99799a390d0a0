// SPDX-License-Identifier: Apache-2.0
// What one camera does when its view changes abruptly: exposure, a cover, a fast rotation, a jump to another place.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "rastro/slam/lsd/method.h"
#include "rastro/slam/lsd/tracking/alignment_testing.h"

namespace rastro {
namespace {

constexpr int frames = 75;
constexpr double rate_hz = 30.0;

/// Walks sideways and up in front of the boxes.
SE3 walk(int k) { return {SO3::exp({0.0, 0.001 * k, 0.0}), {-0.3 + 0.012 * k, 0.06 * std::sin(0.12 * k), 0.003 * k}}; }

struct DisturbedRun {
  std::vector<SlamUpdate> updates;
  Trajectory trajectory;

  int count(SlamState state, int first, int end) const {
    return static_cast<int>(std::count_if(updates.begin() + first, updates.begin() + end,
                                          [&](const SlamUpdate& update) { return update.state == state; }));
  }
  /// Frames from `first` on until the first one with a pose.
  int frames_until_back(int first) const {
    const auto has_pose = [](const SlamUpdate& update) {
      return update.state != SlamState::lost && update.state != SlamState::initializing;
    };
    return static_cast<int>(std::find_if(updates.begin() + first, updates.end(), has_pose) - updates.begin()) - first;
  }
};

const std::vector<GrayImage>& walked_images() {
  static const std::vector<GrayImage> images = [] {
    testing::AlignmentRoom room;
    std::vector<GrayImage> made;
    for (int k = 0; k < frames; ++k) made.push_back(room.render(walk(k)).gray);
    return made;
  }();
  return images;
}

/// `image_of` gives the image of a frame.
DisturbedRun run_with(const std::function<GrayImage(int)>& image_of, const std::string& assignment = {},
                      int count = frames) {
  testing::AlignmentRoom room;
  SourceInfo info;
  info.path = "room";
  info.cameras.push_back({"cam0", room.camera(), std::nullopt, "generated"});
  const auto method = lsd_slam_method();
  if (!assignment.empty()) method->options().set_assignment(assignment, "test");
  const auto slam = method->make(info, {});
  DisturbedRun run;
  for (int k = 0; k < count; ++k) {
    Frame frame;
    frame.index = k;
    frame.stamp = static_cast<TimeNs>(k / rate_hz * 1e9);
    frame.image = image_of(k);
    run.updates.push_back(slam->process(frame));
  }
  slam->finish();
  run.trajectory = slam->trajectory();
  return run;
}

/// Largest distance of a pose from the truth, as a share of the path, after the scale and the first pose are aligned.
double largest_error(const DisturbedRun& run) {
  const auto truth = [](const StampedPose& pose) {
    return walk(static_cast<int>(std::lround(1e-9 * rate_hz * static_cast<double>(pose.stamp))));
  };
  const SE3 true_start = truth(run.trajectory.front()), start = run.trajectory.front().world_from_body;
  double dot = 0.0, squares = 0.0, path = 0.0, largest = 0.0;
  for (const StampedPose& pose : run.trajectory) {
    const Eigen::Vector3d estimated = (start.inverse() * pose.world_from_body).translation();
    const Eigen::Vector3d real = (true_start.inverse() * truth(pose)).translation();
    dot += estimated.dot(real), squares += estimated.squaredNorm(), path = std::max(path, real.norm());
  }
  for (const StampedPose& pose : run.trajectory) {
    const Eigen::Vector3d estimated = (start.inverse() * pose.world_from_body).translation();
    const Eigen::Vector3d real = (true_start.inverse() * truth(pose)).translation();
    largest = std::max(largest, (dot / squares * estimated - real).norm());
  }
  return largest / path;
}

TEST(LsdDisturbance, ExposureThatDoublesAndHalvesIsTracked) {
  // Dark enough that twice the exposure does not clip.
  const auto exposure = [](int k) { return k < 40 || k >= 50 ? 1.0 : std::exp2(std::sin((k - 40) * 0.2 * 3.14159)); };
  const DisturbedRun run = run_with([&](int k) {
    return testing::exposed(walked_images()[static_cast<std::size_t>(k)], 0.5 * exposure(k), 5.0, 0.0, 1);
  });
  EXPECT_EQ(run.count(SlamState::tracking, 35, frames), frames - 35);
  EXPECT_LT(largest_error(run), 0.03);
}

/// No frame is certain enough: the one at which the map begins has no pose of its own, and says so.
TEST(LsdDisturbance, AFrameThatDoesNotFitTheMapThatItBeginsIsNotTracked) {
  constexpr int count = 35;
  const DisturbedRun run =
      run_with([](int k) { return walked_images()[static_cast<std::size_t>(k)]; }, "trusted_sigma=0", count);
  const auto begins_map = [](const SlamUpdate& update) { return !update.events.empty(); };
  const auto first = std::find_if(run.updates.begin(), run.updates.end(), begins_map);
  ASSERT_NE(first, run.updates.end());
  EXPECT_EQ(first->events.front().kind, "keyframe");
  EXPECT_EQ(first->state, SlamState::lost);
  EXPECT_EQ(first->reason, SlamReason::poor_match);
  EXPECT_EQ(run.count(SlamState::tracking, 0, count), 0);
}

TEST(LsdDisturbance, ACoveredCameraIsLostAndBackWithinASecond) {
  const DisturbedRun run = run_with(
      [](int k) { return k >= 35 && k < 65 ? GrayImage(320, 240) : walked_images()[static_cast<std::size_t>(k)]; });
  EXPECT_EQ(run.count(SlamState::lost, 35, 65), 30);
  EXPECT_LE(run.frames_until_back(65), 9);
  EXPECT_LT(largest_error(run), 0.03);
}

TEST(LsdDisturbance, AfterACoverAPoseIsBelievedByThreeFrames) {
  const DisturbedRun run = run_with(
      [](int k) { return k >= 35 && k < 50 ? GrayImage(320, 240) : walked_images()[static_cast<std::size_t>(k)]; });
  for (const int k : {50, 51}) {
    EXPECT_EQ(run.updates[static_cast<std::size_t>(k)].state, SlamState::lost);
    EXPECT_EQ(run.updates[static_cast<std::size_t>(k)].reason, SlamReason::unconfirmed);
  }
  EXPECT_EQ(run.updates[52].state, SlamState::relocalized);
}

TEST(LsdDisturbance, AfterAnAbruptRotationBySixtyDegreesItIsBack) {
  testing::AlignmentRoom room;
  // Away within three frames, back half a second later.
  const auto yaw = [](int k) { return 1.05 * std::clamp(std::min(k - 40, 58 - k) / 3.0, 0.0, 1.0); };
  const DisturbedRun run = run_with([&](int k) {
    return room.render(walk(k) * SE3(SO3::exp({0.0, yaw(k), 0.0}), Eigen::Vector3d::Zero())).gray;
  });
  EXPECT_LE(run.frames_until_back(58), 17);
  EXPECT_EQ(run.count(SlamState::tracking, 70, frames), frames - 70);
  EXPECT_LT(largest_error(run), 0.03);
}

/// Largest error of the rotation since frame `first`, in degrees.
double largest_rotation_error_deg(const DisturbedRun& run, int first, const std::function<SE3(int)>& pose) {
  SO3 estimated_start;
  double largest = 0.0;
  for (const StampedPose& stamped : run.trajectory) {
    const int k = static_cast<int>(std::lround(1e-9 * rate_hz * static_cast<double>(stamped.stamp)));
    const SO3& estimated = stamped.world_from_body.rotation();
    if (k == first) estimated_start = estimated;
    const SO3 real = pose(first).rotation().inverse() * pose(k).rotation();
    if (k >= first) largest = std::max(largest, (real.inverse() * estimated_start.inverse() * estimated).log().norm());
  }
  return largest * 57.3;
}

/// By 52 degrees.
SE3 turning_walk(int k) {
  const double yaw = 0.03 * std::clamp(k - 40, 0, 30);
  return walk(k) * SE3(SO3::exp({0.0, yaw, 0.0}), Eigen::Vector3d::Zero());
}

TEST(LsdDisturbance, DepthsArisePromptlyWhereAWalkTurns) {
  // With a new keyframe after every few frames: each begins with less in view than the one before unless the frames
  // right before it give depths to what came into view.
  testing::AlignmentRoom room;
  const DisturbedRun run = run_with([&](int k) { return room.render(turning_walk(k)).gray; });
  // At its end 260 pixels are left, and the scale is known to a third of itself: it is lost, not followed at any scale.
  EXPECT_EQ(run.count(SlamState::lost, 40, 67), 0);
  EXPECT_LT(largest_rotation_error_deg(run, 40, turning_walk), 3.0);
}

TEST(LsdDisturbance, WhereATurnLeavesTheScaleUncertainFramesAreWeak) {
  testing::AlignmentRoom room;
  const DisturbedRun run =
      run_with([&](int k) { return room.render(turning_walk(k)).gray; }, "max_keyframe_scale_error=1");
  const auto is_uncertain = [](const SlamUpdate& update) {
    return update.state == SlamState::weak && update.reason == SlamReason::uncertain_scale;
  };
  const auto first = std::find_if(run.updates.begin(), run.updates.end(), is_uncertain);
  EXPECT_GT(first - run.updates.begin(), 50) << "it turns from 40 on";
  ASSERT_LT(first - run.updates.begin(), 69);
  EXPECT_TRUE(std::all_of(first, run.updates.begin() + 69, is_uncertain)) << "nothing known comes into view";
}

TEST(LsdDisturbance, WhatHidesMostOfTheViewIsNotFollowed) {
  // A poster comes down in front of the lens, over two thirds of the image.
  // Upside down, so that it is no view of the room.
  GrayImage poster = walked_images().front();
  for (int y = 0; y < poster.height(); ++y) std::reverse(poster.row(y), poster.row(y) + poster.width());
  for (int y = 0; y < poster.height() / 2; ++y)
    std::swap_ranges(poster.row(y), poster.row(y) + poster.width(), poster.row(poster.height() - 1 - y));
  const auto lower_edge = [](int k) { return 160 - 10 * std::abs(k - 55); };
  const DisturbedRun run = run_with([&](int k) {
    GrayImage image = walked_images()[static_cast<std::size_t>(k)];
    for (int y = 0; y < lower_edge(k); ++y)
      for (int x = 0; x < image.width(); ++x) image.at(x, y) = poster.at(x, y - lower_edge(k) + 240);
    return image;
  });
  EXPECT_GT(run.count(SlamState::lost, 40, 70) + run.count(SlamState::weak, 40, 70), 5);
  EXPECT_LT(largest_error(run), 0.05);
}

}  // namespace
}  // namespace rastro
