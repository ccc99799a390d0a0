// SPDX-License-Identifier: Apache-2.0
// Test drive: the first bend of the generated street, for the odometries that measure rotation from intensity profiles.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/math/alignment.h"
#include "rastro/odometry/odometry.h"
#include "rastro/synthetic/worlds/street.h"

namespace rastro {

struct Drive {
  std::vector<Frame> frames;
  Trajectory ground_truth;
  Camera camera;
};

/// Frames of the first bend of the generated street. A larger image takes longer to render.
inline Drive first_bend(double scale) {
  StreetOptions options;
  options.scale = scale;
  const World street = make_street(options);
  Drive drive;
  drive.camera = street.camera();
  const auto source = synthetic_source(street, 46, 2);
  drive.ground_truth = source->info().ground_truth;
  while (auto frame = source->next()) drive.frames.push_back(std::move(*frame));
  return drive;
}

/// What an odometry reported for every frame of a drive, and its poses at the end.
struct DriveResult {
  std::vector<OdometryUpdate> updates;
  Trajectory trajectory;

  int count(OdometryReason reason) const {
    return static_cast<int>(
        std::count_if(updates.begin(), updates.end(), [&](const auto& u) { return u.reason == reason; }));
  }
};

inline DriveResult run(Odometry& odometry, const std::vector<Frame>& frames) {
  DriveResult result;
  for (const Frame& frame : frames) result.updates.push_back(odometry.process(frame));
  result.trajectory = odometry.trajectory();
  return result;
}

inline void expect_sound(const DriveResult& result, std::size_t frames) {
  ASSERT_EQ(result.trajectory.size(), frames);
  double longest = 0.0, path = 0.0;
  for (std::size_t i = 0; i < frames; ++i) {
    const SE3& pose = result.trajectory[i].world_from_body;
    ASSERT_TRUE(pose.matrix().allFinite()) << i;
    if (i == 0) continue;
    const double step = (pose.translation() - result.trajectory[i - 1].world_from_body.translation()).norm();
    longest = std::max(longest, step);
    path += step;
  }
  EXPECT_LT(longest, 8.0 * path / static_cast<double>(frames)) << "a implausible pose";
}

/// Error of the yaw between the first and the last pose, in degrees.
inline double yaw_error_deg(const Trajectory& estimate, const Trajectory& ground_truth) {
  const auto rotation = [](const Trajectory& t) {
    return t.front().world_from_body.rotation().inverse() * t.back().world_from_body.rotation();
  };
  return std::abs((rotation(estimate).inverse() * rotation(ground_truth)).log().y()) * 180.0 / std::numbers::pi;
}

/// Root mean square of the positions after alignment with scale, as a share of the path length.
inline double path_error(const Trajectory& estimate, const Trajectory& ground_truth) {
  std::vector<Eigen::Vector3d> there, ours;
  double length = 0.0;
  for (std::size_t i = 0; i < ground_truth.size(); ++i) {
    there.push_back(ground_truth[i].world_from_body.translation());
    ours.push_back(estimate[i].world_from_body.translation());
    if (i > 0) length += (there[i] - there[i - 1]).norm();
  }
  const auto alignment = align_points(there, ours, AlignmentKind::similarity);
  return alignment ? alignment->rmse / length : 1e9;
}

/// A black frame, a repeated one, and 30 missing ones.
inline std::vector<Frame> spoilt(const std::vector<Frame>& frames) {
  std::vector<Frame> result(frames.begin(), frames.begin() + 14);
  result[8].image = GrayImage(frames[8].image.width(), frames[8].image.height());
  result[10].image = result[9].image;
  result.insert(result.end(), frames.begin() + 43, frames.end());
  return result;
}

/// Frames without information are reported and bridged, and the odometry continues after them.
inline void expect_spoilt_frames_are_bridged(Odometry& odometry, const Drive& drive) {
  const auto bad = spoilt(drive.frames);
  const DriveResult result = run(odometry, bad);
  expect_sound(result, bad.size());
  EXPECT_EQ(result.updates[8].reason, OdometryReason::dark_or_blank);
  EXPECT_EQ(result.updates[10].reason, OdometryReason::repeated_frame);
  EXPECT_FALSE(result.updates[8].used || result.updates[10].used);
  EXPECT_EQ(result.updates[14].reason, OdometryReason::gap);
  EXPECT_NE(result.updates[14].state, OdometryState::tracking);
  EXPECT_EQ(result.updates[11].state, OdometryState::tracking);
}

/// The same image over and over, with fresh noise.
inline std::vector<Frame> standing_still(const Frame& first, std::size_t count) {
  std::vector<Frame> frames(count, first);
  Random random(1);
  for (std::size_t i = 0; i < count; ++i) {
    frames[i].stamp += static_cast<TimeNs>(i) * 100'000'000;
    GrayImage& image = frames[i].image;
    for (int y = 0; y < image.height(); ++y) {
      for (std::uint8_t* pixel = image.row(y); pixel != image.row(y) + image.width(); ++pixel)
        *pixel = static_cast<std::uint8_t>(std::clamp(*pixel + 1.5 * random.normal(), 0.0, 255.0));
    }
  }
  return frames;
}

/// A camera at rest does not move in the estimate, and blank frames are reported.
inline void expect_still_and_dark_frames_are_said(Odometry& still, Odometry& dark, const Drive& drive) {
  const DriveResult stood = run(still, standing_still(drive.frames[0], 12));
  EXPECT_EQ(stood.count(OdometryReason::no_motion), 11);
  EXPECT_EQ(stood.trajectory.back().world_from_body.translation().norm(), 0.0);
  std::vector<Frame> blank(4);
  for (std::size_t i = 0; i < blank.size(); ++i) blank[i].stamp = static_cast<TimeNs>(i) * 100'000'000;
  EXPECT_EQ(run(dark, blank).count(OdometryReason::dark_or_blank), 4);
}

}  // namespace rastro
