// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/ekf_slam.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/map/scans/scan_layer.h"
#include "rastro/slam/ekf/ekf_testing.h"

namespace rastro {
namespace {

using testing::LandmarkDrive;
using testing::LandmarkWorld;
using testing::ring_world;
using testing::room_world;

double nees_of(const SlamUpdate& update, const SE2& ground_truth) {
  const SE2 pose = {SO2::from_angle(update.world_from_body.rotation().log().z()),
                    update.world_from_body.translation().head<2>()};
  Eigen::Vector3d error;
  error << pose.translation() - ground_truth.translation(),
      (ground_truth.rotation().inverse() * pose.rotation()).angle();
  Eigen::Matrix3d covariance;
  constexpr int planar[3] = {0, 1, 5};
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) covariance(a, b) = (*update.covariance)(planar[a], planar[b]);
  }
  return error.dot(covariance.inverse() * error);
}

struct Consistency {
  double share_inside = 0.0;  ///< Of the steps.
  double mean = 0.0;          ///< Of NEES over runs and steps; 3 when consistent.
};

/// The mean NEES of 50 runs must lie in [2.36, 3.72] at 95 % of the steps: chi-square of 150 degrees of freedom has 95
/// % between 117.98 and 185.80 (Bar-Shalom, Li and Kirubarajan 2001, 5.4.2).
Consistency consistency_of(const LandmarkWorld& world, const EkfOptions& options, int steps) {
  constexpr int runs = 50;
  std::vector<double> sums(static_cast<std::size_t>(steps), 0.0);
  for (int run = 0; run < runs; ++run) {
    LandmarkDrive drive(world, options, static_cast<std::uint64_t>(run) + 1);
    EkfSlam slam(options, false);
    slam.process(drive.next());
    for (double& sum : sums) {
      const SlamUpdate update = slam.process(drive.next());
      sum += nees_of(update, drive.world_from_body());
    }
  }
  Consistency result;
  for (const double sum : sums) {
    const double mean = sum / runs;
    result.mean += mean / steps;
    if (mean >= 117.98 / runs && mean <= 185.80 / runs) result.share_inside += 1.0 / steps;
  }
  return result;
}

TEST(EkfSlam, IsConsistentOverFiftyRuns) {
  const Consistency found = consistency_of(ring_world(20, 5), EkfOptions(), 250);
  RecordProperty("share_inside", std::to_string(found.share_inside));
  RecordProperty("mean", std::to_string(found.mean));
  // Measured: 0.916 and 3.22. Steps of one run are correlated, so less than 95 % of them may be inside. A covariance
  // that is 5 % too large or too small moves the mean outside.
  EXPECT_GE(found.share_inside, 0.90);
  EXPECT_GT(found.mean, 3.11);
  EXPECT_LT(found.mean, 3.32);
}

TEST(EkfSlam, IsOverconfidentWhereTheHeadingIsUncertain) {
  // The known inconsistency (Julier and Uhlmann 2001; Huang and Dissanayake 2007): linearization at wrong headings
  // makes the filter gain spurious information about the heading. Odometry that is twenty times worse shows it.
  EkfOptions options;
  options.odometry_error_deg_per_45_deg = 40.0;
  options.heading_error_deg_per_m = 20.0;
  options.named_gate = 1e6;
  const Consistency found = consistency_of(ring_world(20, 5), options, 250);
  EXPECT_GT(found.mean, 3.72);
}

/// A frame with odometry straight ahead at 1 m/s and one landmark at (5, 1).
Frame frame_at(std::int64_t index) {
  Frame frame;
  frame.index = index;
  frame.stamp = 1'000'000'000 + index * 100'000'000;
  const double x = 0.1 * static_cast<double>(index);
  frame.odometry_from_body = SE2(SO2(), {x, 0.0});
  frame.landmarks.push_back({3, std::hypot(5.0 - x, 1.0), std::atan2(1.0, 5.0 - x)});
  return frame;
}

struct Drive {
  EkfSlam slam{EkfOptions(), false};
  std::int64_t next = 0;
  SlamUpdate go(int frames) {
    SlamUpdate update;
    for (int i = 0; i < frames; ++i) update = slam.process(frame_at(next++));
    return update;
  }
  double x() const { return slam.filter().world_from_body().translation().x(); }
};

TEST(EkfSlam, BeginsAtTheOriginAndTracks) {
  Drive drive;
  const SlamUpdate first = drive.go(1);
  EXPECT_EQ(first.state, SlamState::tracking);
  EXPECT_EQ(first.reason, SlamReason::first_frame);
  EXPECT_EQ(first.world_from_body.translation().norm(), 0.0);
  EXPECT_EQ(first.covariance->norm(), 0.0);
  const SlamUpdate later = drive.go(9);
  EXPECT_EQ(later.state, SlamState::tracking);
  EXPECT_EQ(later.reason, SlamReason::none);
  EXPECT_EQ(later.used, 1);
  EXPECT_EQ(later.score, 1.0);
  EXPECT_NEAR(drive.x(), 0.9, 1e-9);
  EXPECT_EQ(drive.slam.trajectory().size(), 10U);
}

LandmarkLayer landmarks_of(const Map& map) { return *map.layer<LandmarkLayer>(); }

TEST(EkfSlam, ALandmarkIsConfirmedAfterTheGivenObservationsWithItsId) {
  Drive drive;
  EXPECT_TRUE(drive.go(4).events.empty());
  EXPECT_TRUE(landmarks_of(*drive.slam.snapshot()).landmarks.empty());
  const SlamUpdate fifth = drive.go(1);
  ASSERT_EQ(fifth.events.size(), 1U);
  EXPECT_EQ(fifth.events[0].kind, "landmark");
  drive.go(3);
  const LandmarkLayer known = landmarks_of(*drive.slam.snapshot());
  ASSERT_EQ(known.landmarks.size(), 1U);
  ASSERT_EQ(known.estimates.size(), 1U);
  EXPECT_EQ(known.estimates[0].sensor_id, 3);
  EXPECT_EQ(known.estimates[0].observations, 8);
  EXPECT_LT((known.landmarks[0].position - Eigen::Vector3d(5.0, 1.0, 0.0)).norm(), 1e-6);
}

TEST(EkfSlam, ASnapshotDoesNotChangeUnderItsReader) {
  Drive drive;
  drive.go(8);
  const auto snapshot = drive.slam.snapshot();
  const LandmarkEstimate before = landmarks_of(*snapshot).estimates.at(0);
  drive.go(8);
  EXPECT_EQ(landmarks_of(*snapshot).estimates.at(0).observations, before.observations);
  EXPECT_EQ(landmarks_of(*snapshot).estimates.at(0).covariance, before.covariance);
  EXPECT_GT(drive.slam.snapshot()->revision, snapshot->revision);
  EXPECT_LT(landmarks_of(*drive.slam.snapshot()).estimates.at(0).covariance.trace(), before.covariance.trace());
}

TEST(EkfSlam, ARepeatedOrBackwardStampIsNotUsed) {
  Drive drive;
  drive.go(8);
  for (const std::int64_t index : {7, 3}) {
    const SlamUpdate update = drive.slam.process(frame_at(index));
    EXPECT_EQ(update.state, SlamState::weak);
    EXPECT_EQ(update.reason, SlamReason::repeated_frame);
    EXPECT_NEAR(update.world_from_body.translation().x(), 0.7, 1e-9);
  }
  EXPECT_EQ(drive.slam.trajectory().size(), 8U);
  EXPECT_EQ(drive.go(1).reason, SlamReason::none);
  EXPECT_NEAR(drive.x(), 0.8, 1e-9);
}

TEST(EkfSlam, MissingOdometryIsReplacedByTheLastMotion) {
  Drive drive;
  const double sure = drive.go(8).covariance->trace();
  Frame without = frame_at(drive.next++);
  without.odometry_from_body.reset();
  without.landmarks.clear();
  const SlamUpdate update = drive.slam.process(without);
  EXPECT_EQ(update.state, SlamState::weak);
  EXPECT_EQ(update.reason, SlamReason::no_odometry);
  EXPECT_NEAR(drive.x(), 0.8, 1e-9);
  EXPECT_GT(update.covariance->trace(), 2.0 * sure);
  EXPECT_EQ(drive.go(1).reason, SlamReason::no_odometry);  // no difference to the frame before
  EXPECT_EQ(drive.go(1).reason, SlamReason::none);
  EXPECT_NEAR(drive.x(), 1.0, 1e-6);
}

TEST(EkfSlam, OdometryThatJumpsIsReportedAndNotUsed) {
  for (const double jump : {100.0, 1e300, std::numeric_limits<double>::infinity()}) {
    Drive drive;
    drive.go(8);
    for (int i = 0; i < 3; ++i) {  // it continues from where it jumped to
      Frame frame = frame_at(drive.next++);
      frame.odometry_from_body = SE2(SO2(), {frame.odometry_from_body->translation().x() + jump, 0.0});
      const SlamUpdate update = drive.slam.process(frame);
      if (i == 0) {
        EXPECT_EQ(update.state, SlamState::weak);
        EXPECT_EQ(update.reason, std::isfinite(jump) ? SlamReason::odometry_jumped : SlamReason::no_odometry);
      }
      EXPECT_NEAR(drive.x(), 0.1 * static_cast<double>(drive.next - 1), 0.2);
    }
  }
}

TEST(EkfSlam, LandmarksCarryItWhileOdometryStaysTheSame) {
  const auto frame_with_two = [](std::int64_t index) {
    Frame frame = frame_at(index);
    const double x = frame.odometry_from_body->translation().x();
    frame.landmarks.push_back({4, std::hypot(8.0 - x, 2.0), std::atan2(-2.0, 8.0 - x)});
    return frame;
  };
  Drive drive;
  while (drive.next < 20) drive.slam.process(frame_with_two(drive.next++));
  const SE2 frozen = *frame_at(19).odometry_from_body;
  int weak = 0;
  for (int i = 0; i < 20; ++i) {
    Frame frame = frame_with_two(drive.next++);
    if (i < 15) frame.odometry_from_body = frozen;
    weak += drive.slam.process(frame).reason == SlamReason::no_odometry ? 1 : 0;
    EXPECT_NEAR(drive.x(), 0.1 * static_cast<double>(drive.next - 1), i < 5 ? 0.5 : 0.15) << i;
  }
  EXPECT_GE(weak, 11);
  EXPECT_LE(weak, 16);
}

TEST(EkfSlam, ALandmarkSeenFirstWhileOdometryIsFrozenIsNotTakenIn) {
  EkfSlam slam(EkfOptions(), false);
  for (int k = 0; k < 20; ++k) {
    Frame frame;
    frame.index = k;
    frame.stamp = k * ns_per_second / 10;
    frame.odometry_from_body = SE2();
    frame.scan.emplace();
    frame.scan->max_range = 20.0;
    frame.scan->angle_step = 0.02;
    frame.scan->ranges.assign(100, 5.0F + 0.05F * static_cast<float>(k));
    if (k == 15) frame.landmarks.push_back({3, 4.0, 0.1});
    const SlamUpdate update = slam.process(frame);
    if (k != 15) continue;
    EXPECT_EQ(update.reason, SlamReason::no_odometry);
    EXPECT_EQ(update.used, 0);
    ASSERT_EQ(slam.observations().size(), 1U);
    EXPECT_LT(slam.observations().front().landmark, 0);
  }
}

TEST(EkfSlam, ALongPathWithoutLandmarksIsWeak) {
  EkfSlam slam(EkfOptions(), false);
  SlamUpdate update;
  for (int i = 0; i < 30; ++i) {
    Frame frame = frame_at(i);
    frame.landmarks.clear();
    update = slam.process(frame);
    EXPECT_EQ(update.state, 0.1 * i > 1.0 + 1e-9 ? SlamState::weak : SlamState::tracking) << i;
  }
  EXPECT_EQ(update.reason, SlamReason::too_few_points);
}

TEST(EkfSlam, MissingAndEmptyScansAreReported) {
  EkfSlam slam(EkfOptions(), true);
  Frame frame = frame_at(0);
  frame.landmarks.clear();
  EXPECT_EQ(slam.process(frame).reason, SlamReason::no_data);
  frame = frame_at(1);
  frame.scan.emplace();
  frame.scan->ranges.assign(180, 80.0F);
  frame.scan->max_range = 80.0;
  const SlamUpdate update = slam.process(frame);
  EXPECT_EQ(update.reason, SlamReason::few_returns);
  EXPECT_EQ(update.state, SlamState::weak);
  EXPECT_NE(update.detail.find("0 of 180"), std::string::npos);
}

TEST(EkfSlam, ObservationsThatContradictTheMapAreReportedAndNotUsed) {
  Drive drive;
  Frame frame;
  for (int i = 0; i < 8; ++i) {
    frame = frame_at(i);
    frame.landmarks.push_back({4, 6.0, -1.0});
    drive.slam.process(frame);
  }
  frame = frame_at(8);
  frame.landmarks = {{3, 9.0, 2.0}, {4, 1.0, 1.0}, {5, -1.0, 0.0}, {6, std::nan(""), 0.0}, {7, 1.0, std::nan("")}};
  const SlamUpdate update = drive.slam.process(frame);
  EXPECT_EQ(update.reason, SlamReason::poor_match);
  EXPECT_EQ(update.used, 0);
  EXPECT_EQ(update.score, 0.0);
}

TEST(EkfSlam, ReportsTheOdometryError) {
  for (const double scale : {0.3, 4.0}) {
    LandmarkWorld world = ring_world(20, 5);
    world.odometry_scale = scale;
    LandmarkDrive drive(world, EkfOptions(), 1);
    EkfSlam slam(EkfOptions(), false);
    for (int i = 0; i < 250; ++i) slam.process(drive.next());
    const auto events = slam.finish();
    ASSERT_EQ(events.size(), 1U);
    EXPECT_EQ(events[0].kind, "odometry");
    EXPECT_NE(events[0].detail.find(scale < 1.0 ? "within" : "beyond"), std::string::npos) << events[0].detail;
  }
}

TEST(EkfSlam, IsWeakAndUncertainWhereLandmarksAndOdometryContradictEachOther) {
  for (const double scale : {1.0, 10.0}) {
    LandmarkWorld world = ring_world(20, 5);
    world.odometry_scale = scale;
    LandmarkDrive drive(world, EkfOptions(), 1);
    EkfSlam slam(EkfOptions(), false);
    SlamUpdate update;
    for (int i = 0; i < 250; ++i) update = slam.process(drive.next());
    EXPECT_EQ(update.state, scale > 1.0 ? SlamState::weak : SlamState::tracking);
    const double of_filter = slam.filter().body_covariance().trace();
    EXPECT_GT(update.covariance->trace(), (scale > 1.0 ? 9.0 : 0.99) * of_filter);
    EXPECT_LT(update.covariance->trace(), (scale > 1.0 ? 1000.0 : 1.01) * of_filter);
  }
}

/// Largest distance of the filter and of odometry from ground truth in the second half of a drive.
struct Farthest {
  double filter = 0.0, odometry = 0.0;
};

Farthest farthest_of(const LandmarkWorld& world, int frames, std::uint64_t seed, bool scans, EkfSlam& slam) {
  LandmarkDrive drive(world, EkfOptions(), seed);
  Farthest farthest;
  for (int i = 0; i < frames; ++i) {
    Frame frame = drive.next();
    if (!scans) frame.scan.reset();
    slam.process(frame);
    if (i < frames / 2) continue;
    const Eigen::Vector2d ground_truth = drive.world_from_body().translation();
    farthest.filter = std::max(farthest.filter, (slam.filter().world_from_body().translation() - ground_truth).norm());
    farthest.odometry = std::max(farthest.odometry, (frame.odometry_from_body->translation() - ground_truth).norm());
  }
  return farthest;
}

TEST(EkfSlam, LocalizesByTheCornersAndPolesOfARoom) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    EkfSlam slam(EkfOptions(), true);
    const Farthest farthest = farthest_of(room_world(), 260, seed, true, slam);
    EXPECT_LT(farthest.filter, 0.05);
    EXPECT_GT(farthest.odometry, 0.3);
    // 8 corners of the room and 2 poles; those of the pillars have too few beams to be observed often.
    EXPECT_GE(landmarks_of(*slam.snapshot()).landmarks.size(), 8U);
    EXPECT_LE(landmarks_of(*slam.snapshot()).landmarks.size(), 12U);
  }
}

TEST(EkfSlam, WorksWithLandmarksWithoutIds) {
  LandmarkWorld world = ring_world(20, 5);
  world.named = false;
  EkfSlam slam(EkfOptions(), false);
  const Farthest farthest = farthest_of(world, 260, 1, false, slam);
  EXPECT_LT(farthest.filter, 0.25);
  EXPECT_GT(farthest.odometry, 0.5);
  EXPECT_LE(landmarks_of(*slam.snapshot()).landmarks.size(), 22U);
}

std::string bytes_of(const Trajectory& trajectory) {
  std::string bytes;
  for (const auto& [stamp, pose] : trajectory) {
    const Eigen::Matrix4d matrix = pose.matrix();
    bytes.append(reinterpret_cast<const char*>(matrix.data()), sizeof(double) * 16);
  }
  return bytes;
}

TEST(EkfSlam, GivesTheSameBytesAgain) {
  EkfSlam one(EkfOptions(), true), other(EkfOptions(), true);
  farthest_of(room_world(), 100, 1, true, one);
  farthest_of(room_world(), 100, 1, true, other);
  EXPECT_EQ(bytes_of(one.trajectory()), bytes_of(other.trajectory()));
  EXPECT_EQ(occupancy_grid_of(*one.snapshot()).value().percent, occupancy_grid_of(*other.snapshot()).value().percent);
}

}  // namespace
}  // namespace rastro
