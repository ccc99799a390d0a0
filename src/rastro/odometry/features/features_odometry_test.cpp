// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/features/features_odometry.h"

#include <gtest/gtest.h>

#include "rastro/math/alignment.h"
#include "rastro/synthetic/worlds/hall.h"

namespace rastro {
namespace {

const World& hall() {
  static const World world = [] {
    HallOptions options;
    options.scale = 0.5;
    return make_hall(options);
  }();
  return world;
}

/// The first frames of a flight through the generated hall, rendered once for all tests.
struct Flight {
  std::vector<Frame> frames;
  Trajectory ground_truth;
  Camera camera;
};

const Flight& whole_flight() {
  static const Flight made = [] {
    Flight made_now;
    made_now.camera = hall().camera();
    const auto source = synthetic_source(hall(), 66, 2);
    made_now.ground_truth = source->info().ground_truth;
    while (auto frame = source->next()) made_now.frames.push_back(std::move(*frame));
    return made_now;
  }();
  return made;
}

const std::vector<Frame>& all_frames() { return whole_flight().frames; }

/// Its first 40 frames.
const Flight& flight() {
  static const Flight beginning = [] {
    Flight first = whole_flight();
    first.frames.resize(40);
    first.ground_truth.resize(40);
    return first;
  }();
  return beginning;
}

Trajectory run(const std::vector<Frame>& frames, FeaturesOptions options = {}, TaskPool* pool = nullptr) {
  FeaturesOdometry odometry(options, flight().camera, pool);
  for (const Frame& frame : frames) odometry.process(frame);
  return odometry.trajectory();
}

double error_to_ground_truth(const Trajectory& trajectory) {
  std::vector<Eigen::Vector3d> ground_truth, ours;
  for (const StampedPose& pose : trajectory) {
    const auto there = pose_at(flight().ground_truth, pose.stamp, 1'000'000'000);
    if (!there) continue;
    ground_truth.push_back(there->translation());
    ours.push_back(pose.world_from_body.translation());
  }
  const auto alignment = align_points(ground_truth, ours, AlignmentKind::similarity);
  return alignment ? alignment->rmse : 1e9;
}

double path_of(const Trajectory& trajectory) {
  double length = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    length += (trajectory[i].world_from_body.translation() - trajectory[i - 1].world_from_body.translation()).norm();
  return length;
}

void expect_sound(const Trajectory& trajectory, std::size_t frames) {
  ASSERT_EQ(trajectory.size(), frames);
  for (const StampedPose& pose : trajectory) {
    ASSERT_TRUE(pose.world_from_body.matrix().allFinite());
    const Eigen::Matrix3d rotation = pose.world_from_body.rotation().matrix();
    ASSERT_LT((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-9);
  }
}

TEST(FeaturesOdometry, TracksTheFlightThroughTheHall) {
  const Trajectory trajectory = run(flight().frames);
  expect_sound(trajectory, flight().frames.size());
  const double length = path_of(flight().ground_truth);
  EXPECT_LT(error_to_ground_truth(trajectory), 0.02 * length);
}

TEST(FeaturesOdometry, TheSameBytesOnARerunAndForAnyPool) {
  const std::vector<Frame> frames(flight().frames.begin(), flight().frames.begin() + 20);
  TaskPool pool(3);
  const Trajectory once = run(frames), again = run(frames), pooled = run(frames, {}, &pool);
  ASSERT_EQ(once.size(), pooled.size());
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].world_from_body.matrix(), again[i].world_from_body.matrix());
    EXPECT_EQ(once[i].world_from_body.matrix(), pooled[i].world_from_body.matrix());
  }
}

TEST(FeaturesOdometry, ACameraAtRestDoesNotMove) {
  std::vector<Frame> frames;
  for (int i = 0; i < 8; ++i) {
    frames.push_back(flight().frames[0]);
    frames.back().stamp += i * 50'000'000LL;
    frames.back().image.at(10 + i, 10) ^= 8;
  }
  const Trajectory trajectory = run(frames);
  expect_sound(trajectory, frames.size());
  EXPECT_EQ(path_of(trajectory), 0.0);
}

TEST(FeaturesOdometry, BlackFramesAreReportedAndBridged) {
  std::vector<Frame> frames = flight().frames;
  for (const std::size_t k : {18U, 19U}) frames[k].image = GrayImage(frames[k].image.width(), frames[k].image.height());
  FeaturesOdometry odometry({}, flight().camera);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const OdometryUpdate update = odometry.process(frames[k]);
    if (k == 18 || k == 19) {
      EXPECT_EQ(update.reason, OdometryReason::dark_or_blank);
      EXPECT_FALSE(update.used);
    }
  }
  expect_sound(odometry.trajectory(), frames.size());
  EXPECT_LT(error_to_ground_truth(odometry.trajectory()), 0.05 * path_of(flight().ground_truth));
}

TEST(FeaturesOdometry, ARepeatedFrameAndAnEmptyOneAreNoError) {
  std::vector<Frame> frames(flight().frames.begin(), flight().frames.begin() + 20);
  frames[12] = frames[11];
  frames[15].image = GrayImage();
  FeaturesOdometry odometry({}, flight().camera);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const OdometryUpdate update = odometry.process(frames[k]);
    if (k == 12) {
      EXPECT_EQ(update.reason, OdometryReason::repeated_frame);
    }
    if (k == 15) {
      EXPECT_EQ(update.reason, OdometryReason::dark_or_blank);
    }
  }
  expect_sound(odometry.trajectory(), frames.size());
}

TEST(FeaturesOdometry, TheLivePoseStaysUnderRepeatedImagesAlsoAfterADarkOne) {
  FeaturesOdometry odometry({}, flight().camera);
  OdometryUpdate moved;
  for (int k = 0; k < 20; ++k) moved = odometry.process(flight().frames[static_cast<std::size_t>(k)]);
  ASSERT_EQ(moved.state, OdometryState::tracking);
  Frame frame = flight().frames[19];
  const auto next = [&] {
    frame.stamp += 50'000'000;
    return odometry.process(frame);
  };
  for (int k = 0; k < 20; ++k) {
    const OdometryUpdate update = next();
    EXPECT_EQ(update.reason, OdometryReason::repeated_frame);
    EXPECT_EQ(update.world_from_camera.matrix(), moved.world_from_camera.matrix()) << k;
  }
  const GrayImage seen = frame.image;
  frame.image = GrayImage(seen.width(), seen.height());
  next();
  frame.image = seen;
  const OdometryUpdate rest = next();
  EXPECT_EQ(rest.reason, OdometryReason::repeated_frame);
  EXPECT_EQ(rest.world_from_camera.matrix(), moved.world_from_camera.matrix());
}

TEST(FeaturesOdometry, AGapOfOneSecondWithTheSameViewIsWeak) {
  FeaturesOdometry odometry({}, flight().camera);
  for (int k = 0; k < 24; ++k) {
    Frame frame = flight().frames[static_cast<std::size_t>(k)];
    if (k >= 20) frame.stamp += ns_per_second;
    const OdometryUpdate update = odometry.process(frame);
    EXPECT_EQ(update.state == OdometryState::weak, k == 20) << k;
    EXPECT_EQ(update.reason == OdometryReason::gap, k == 20) << k;
  }
}

TEST(FeaturesOdometry, AGapIsReportedAndTheRunContinues) {
  FeaturesOdometry odometry({}, flight().camera);
  std::size_t count = 0;
  bool said = false;
  for (const Frame& frame : all_frames()) {
    if (frame.index >= 25 && frame.index < 55) continue;
    const OdometryUpdate update = odometry.process(frame);
    if (frame.index >= 55 && frame.index < 60) said = said || update.reason != OdometryReason::none;
    if (update.reason == OdometryReason::gap) {
      EXPECT_NE(update.state, OdometryState::tracking) << frame.index;
    }
    ++count;
  }
  EXPECT_TRUE(said);
  expect_sound(odometry.trajectory(), count);
}

/// The flight with focal lengths `factor` times the true ones: number of frames that call the calibration doubtful.
int doubtful_frames(double factor) {
  Camera camera = flight().camera;
  camera.fx *= factor;
  camera.fy *= factor;
  FeaturesOdometry odometry({}, camera);
  int doubtful = 0;
  for (const Frame& frame : all_frames()) {
    const OdometryUpdate update = odometry.process(frame);
    if (update.reason != OdometryReason::calibration_doubtful) continue;
    EXPECT_NE(update.detail.find("check the calibration"), std::string::npos);
    ++doubtful;
  }
  expect_sound(odometry.trajectory(), all_frames().size());
  return doubtful;
}

TEST(FeaturesOdometry, AWrongFocalLengthIsReportedAndTheRunContinues) {
  EXPECT_EQ(doubtful_frames(1.0), 0);
  EXPECT_GT(doubtful_frames(1.1), 0);
  EXPECT_GT(doubtful_frames(0.9), 0);
}

TEST(FeaturesOdometry, SettingsOutOfRangeAreAnError) {
  FeaturesOptions options;
  options.window_keyframes = 1;
  EXPECT_THROW(FeaturesOdometry(options, Camera{}), Error);
}

}  // namespace
}  // namespace rastro
