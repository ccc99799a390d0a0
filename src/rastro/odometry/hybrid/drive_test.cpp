// SPDX-License-Identifier: Apache-2.0
// Both odometries that read turns off profiles, over the first turn of the generated street, which is rendered once.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/math/alignment.h"
#include "rastro/odometry/hybrid/hybrid_odometry.h"
#include "rastro/odometry/profiles/profiles_odometry.h"
#include "rastro/synthetic/worlds/street.h"

namespace rastro {
namespace {

constexpr double degrees = 180.0 / std::numbers::pi;

struct Drive {
  std::vector<Frame> frames;
  Trajectory truth;
  Camera camera;
};

Drive first_turn() {
  StreetOptions options;
  options.scale = 0.4;
  const World street = make_street(options);
  Drive drive;
  drive.camera = street.camera();
  const auto source = synthetic_source(street, 46, 2);
  drive.truth = source->info().ground_truth;
  while (auto frame = source->next()) drive.frames.push_back(std::move(*frame));
  return drive;
}

struct Result {
  std::vector<OdometryUpdate> updates;
  Trajectory trajectory;

  int count(OdometryReason reason) const {
    return static_cast<int>(
        std::count_if(updates.begin(), updates.end(), [&](const auto& u) { return u.reason == reason; }));
  }
};

Result run(Odometry& odometry, const std::vector<Frame>& frames) {
  Result result;
  for (const Frame& frame : frames) result.updates.push_back(odometry.process(frame));
  result.trajectory = odometry.trajectory();
  return result;
}

void expect_sound(const Result& result, std::size_t frames) {
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
  EXPECT_LT(longest, 8.0 * path / static_cast<double>(frames)) << "a wild pose";
}

/// Yaw of the turn from the first to the last pose, in degrees, of an estimate against the truth.
double yaw_error_deg(const Trajectory& estimate, const Trajectory& truth) {
  const auto turn = [](const Trajectory& t) {
    return t.front().world_from_body.rotation().inverse() * t.back().world_from_body.rotation();
  };
  return std::abs((turn(estimate).inverse() * turn(truth)).log().y()) * degrees;
}

double path_error(const Trajectory& estimate, const Trajectory& truth) {
  std::vector<Eigen::Vector3d> there, ours;
  double length = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    there.push_back(truth[i].world_from_body.translation());
    ours.push_back(estimate[i].world_from_body.translation());
    if (i > 0) length += (there[i] - there[i - 1]).norm();
  }
  const auto alignment = align_points(there, ours, AlignmentKind::similarity);
  return alignment ? alignment->rmse / length : 1e9;
}

/// A black frame, a repeated one, and 30 missing ones.
std::vector<Frame> spoilt(const std::vector<Frame>& frames) {
  std::vector<Frame> result(frames.begin(), frames.begin() + 14);
  result[8].image = GreyImage(frames[8].image.width(), frames[8].image.height());
  result[10].image = result[9].image;
  result.insert(result.end(), frames.begin() + 43, frames.end());
  return result;
}

std::unique_ptr<Odometry> make(bool with_points, const Camera& camera, TaskPool* pool = nullptr) {
  if (with_points) return std::make_unique<HybridOdometry>(HybridOptions{}, camera, pool);
  return std::make_unique<ProfilesOdometry>(ProfilesOptions{}, camera);
}

void check_profiles(const Drive& drive) {
  const Result result = run(*make(false, drive.camera), drive.frames);
  expect_sound(result, drive.frames.size());
  EXPECT_LE(yaw_error_deg(result.trajectory, drive.truth), 2.0);
}

void check_hybrid(const Drive& drive) {
  const Result result = run(*make(true, drive.camera), drive.frames);
  expect_sound(result, drive.frames.size());
  EXPECT_LE(path_error(result.trajectory, drive.truth), 0.03);
  EXPECT_EQ(result.updates.back().state, OdometryState::tracking);
  TaskPool pool(3);
  const Result again = run(*make(true, drive.camera, &pool), drive.frames);
  for (std::size_t i = 0; i < drive.frames.size(); ++i) {
    EXPECT_EQ(result.trajectory[i].world_from_body.matrix(), again.trajectory[i].world_from_body.matrix()) << i;
  }
}

void check_spoilt(const Drive& drive, bool with_points) {
  const auto bad = spoilt(drive.frames);
  const Result result = run(*make(with_points, drive.camera), bad);
  expect_sound(result, bad.size());
  EXPECT_EQ(result.updates[8].reason, OdometryReason::dark_or_blank);
  EXPECT_EQ(result.updates[10].reason, OdometryReason::repeated_frame);
  EXPECT_FALSE(result.updates[8].used || result.updates[10].used);
  EXPECT_EQ(result.updates[14].reason, OdometryReason::gap);
  EXPECT_NE(result.updates[14].state, OdometryState::tracking);
  EXPECT_EQ(result.updates[11].state, OdometryState::tracking);
}

/// The same picture over and over, with fresh noise.
std::vector<Frame> standing_still(const Frame& first, std::size_t count) {
  std::vector<Frame> frames(count, first);
  Random random(1);
  for (std::size_t i = 0; i < count; ++i) {
    frames[i].stamp += static_cast<TimeNs>(i) * 100'000'000;
    GreyImage& image = frames[i].image;
    for (int y = 0; y < image.height(); ++y) {
      for (std::uint8_t* pixel = image.row(y); pixel != image.row(y) + image.width(); ++pixel)
        *pixel = static_cast<std::uint8_t>(std::clamp(*pixel + 1.5 * random.normal(), 0.0, 255.0));
    }
  }
  return frames;
}

TEST(Drive, TurnsAndPathsOfTheFirstTurn) {
  const Drive drive = first_turn();
  check_profiles(drive);
  check_hybrid(drive);
  const auto still = standing_still(drive.frames[0], 12);
  std::vector<Frame> dark(4);
  for (std::size_t i = 0; i < dark.size(); ++i) dark[i].stamp = static_cast<TimeNs>(i) * 100'000'000;
  for (const bool with_points : {false, true}) {
    SCOPED_TRACE(with_points ? "hybrid" : "profiles");
    check_spoilt(drive, with_points);
    const Result stood = run(*make(with_points, drive.camera), still);
    EXPECT_EQ(stood.count(OdometryReason::no_motion), 11);
    EXPECT_EQ(stood.trajectory.back().world_from_body.translation().norm(), 0.0);
    EXPECT_EQ(run(*make(with_points, drive.camera), dark).count(OdometryReason::dark_or_blank), 4);
  }
}

TEST(Drive, SettingsOutOfRangeAreErrors) {
  const Camera camera{.width = 400, .height = 300, .fx = 300, .fy = 300, .cx = 200, .cy = 150};
  ProfilesOptions options;
  options.turn.band_top = 0.6;
  EXPECT_THROW(ProfilesOdometry(options, camera), Error);
  EXPECT_THROW(ProfilesOdometry(ProfilesOptions{}, Camera{}), Error);
  HybridOptions defaults;
  EXPECT_GT(option_table(defaults).options().size(), 20U);
  EXPECT_GT(option_table(options).options().size(), 15U);
}

}  // namespace
}  // namespace rastro
