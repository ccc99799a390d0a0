// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/hector_slam.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "rastro/map/scans/scan_layer.h"
#include "rastro/slam/hector/hector_testing.h"

namespace rastro {
namespace {

using testing::planar;
using testing::pose_of;
using testing::ring_drive;
using testing::room_drive;
using testing::WalledDrive;

struct Driven {
  std::vector<SlamUpdate> updates;
  Trajectory trajectory;
  std::shared_ptr<const Map> snapshot;
};

Driven run(const std::vector<Frame>& frames, const HectorOptions& options, TaskPool* pool = nullptr) {
  HectorSlam slam(options, pool);
  Driven result;
  for (const Frame& frame : frames) result.updates.push_back(slam.process(frame));
  slam.finish();
  result.trajectory = slam.trajectory();
  result.snapshot = slam.snapshot();
  return result;
}

OccupancyGrid grid_of(const Driven& done) { return occupancy_grid_of(*done.snapshot).value(); }

Eigen::Vector2d off(const WalledDrive& drive, std::size_t k, const SE3& pose) {
  const SE2 error = drive.ground_truth(k).inverse() * planar(pose);
  return {error.translation().norm(), std::abs(error.rotation().angle())};
}

/// Of all frames, at the end: meters and radians.
Eigen::Vector2d worst_error(const WalledDrive& drive, const Trajectory& trajectory) {
  Eigen::Vector2d worst = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < trajectory.size(); ++k)
    worst = worst.cwiseMax(off(drive, k, trajectory[k].world_from_body));
  return worst;
}

TEST(HectorSlam, AStoppedRunKeepsItsMapAndSearchesForNoMoreLoops) {
  const std::atomic<bool> stop = true;
  HectorSlam slam({}, nullptr, 0, &stop);
  for (const Frame& frame : room_drive(20).frames()) slam.process(frame);
  const auto events = slam.finish();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events.front().kind, "stopped");
  EXPECT_EQ(slam.trajectory().size(), 20U);
}

TEST(HectorSlam, TheFirstScanFitsTheMapThatBeginsWithItExactly) {
  const SlamUpdate first = HectorSlam({}, nullptr).process(room_drive(1).frames().front());
  EXPECT_EQ(first.state, SlamState::tracking);
  EXPECT_EQ(first.reason, SlamReason::first_frame);
  EXPECT_EQ(first.score, 1.0);
  ASSERT_TRUE(first.covariance);
  EXPECT_EQ(first.covariance->norm(), 0.0);
}

TEST(HectorSlam, FollowsADriveThroughARoomWithEveryGuess) {
  const WalledDrive drive = room_drive();
  const std::vector<Frame> frames = drive.frames();
  for (const char* guess : {"odometry", "constant-velocity", "none"}) {
    for (const bool loop_closing : {true, false}) {
      HectorOptions options;
      options.guess = guess;
      options.loop_closing = loop_closing;
      const Driven done = run(frames, options);
      ASSERT_EQ(done.trajectory.size(), frames.size());
      const Eigen::Vector2d worst = worst_error(drive, done.trajectory);
      EXPECT_LT(worst.x(), 0.02) << guess << loop_closing;
      EXPECT_LT(worst.y(), 0.01) << guess << loop_closing;
      EXPECT_EQ(done.updates.front().reason, SlamReason::first_frame);
      for (std::size_t k = 1; k < frames.size(); ++k) {
        EXPECT_EQ(done.updates[k].state, SlamState::tracking);
        EXPECT_EQ(done.updates[k].used, drive.beams);
        EXPECT_LT(off(drive, k, done.updates[k].world_from_body).x(), 0.03);
      }
    }
  }
}

TEST(HectorSlam, ItsMapHasTheWallsAtTheirPositions) {
  const WalledDrive drive = room_drive();
  const OccupancyGrid grid = grid_of(run(drive.frames(), HectorOptions()));
  const SE2 walls_from_world = drive.world_from_body.front();
  int occupied = 0;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (grid.at(x, y) < 60) continue;
      ++occupied;
      const Eigen::Vector2d position = walls_from_world * grid.center_of(x, y);
      const double to_wall = std::min({std::abs(position.x() + 2.0), std::abs(position.x() - 5.0),
                                       std::abs(position.y() + 2.1), std::abs(position.y() - 2.9)});
      EXPECT_LT(to_wall, 0.1);
    }
  }
  EXPECT_GT(occupied, 24.0 / grid.cell_m * 0.7) << "of 24 m of walls";
  const Eigen::Vector2i start = grid.cell_of(Eigen::Vector2d(0.3, 0.0));
  EXPECT_LT(grid.at(start.x(), start.y()), 40);
}

/// Loop closures between the end and the beginning of the drive.
int loops_around(const Map& map) {
  return static_cast<int>(std::count_if(map.constraints.begin(), map.constraints.end(), [&](const Constraint& each) {
    const TimeNs between = map.find(each.to)->stamp - map.find(each.from)->stamp;
    return each.kind == ConstraintKind::loop && std::abs(between) > 15 * ns_per_second;
  }));
}

TEST(HectorSlam, ClosesALoopDespiteWheelSlip) {
  for (const double measured_m : {0.97, 1.03}) {
    WalledDrive drive = ring_drive();
    drive.measured_m = measured_m;
    const std::vector<Frame> frames = drive.frames();
    HectorOptions options;
    const Driven closed = run(frames, options);
    options.loop_closing = false;
    const Driven open = run(frames, options);
    const std::size_t last = frames.size() - 1;
    EXPECT_GT(off(drive, last, open.trajectory[last].world_from_body).x(), 0.12) << "there must be a loop to close";
    EXPECT_LT(off(drive, last, closed.trajectory[last].world_from_body).x(), 0.06);
    EXPECT_GT(loops_around(*closed.snapshot), 0);
    int closed_on_the_way = 0;
    for (const SlamUpdate& update : closed.updates)
      closed_on_the_way += static_cast<int>(std::count_if(update.events.begin(), update.events.end(),
                                                          [](const auto& e) { return e.kind == "loop_closed"; }));
    EXPECT_GT(closed_on_the_way, 0) << "not only at the end";
    EXPECT_EQ(loops_around(*open.snapshot), 0);
  }
}

TEST(HectorSlam, ReportsTheUnobservableDirectionOfACorridor) {
  for (const double heading : {0.5, -1.0, 0.0}) {
    WalledDrive drive;
    drive.walls.add({-50.0, -1.0}, {50.0, -1.0});
    drive.walls.add({-50.0, 1.0}, {50.0, 1.0});
    drive.reach_m = 6.0;
    drive.world_from_body = {pose_of(0.0, 0.1, heading)};
    // Along the corridor, whatever the robot's heading.
    drive.go(SE2(SO2(), SO2::from_angle(-heading) * Eigen::Vector2d(0.1, 0.0)), 20);
    const Driven done = run(drive.frames(), HectorOptions());
    const Eigen::Vector2d along = SO2::from_angle(-heading) * Eigen::Vector2d(1.0, 0.0);
    const Eigen::Vector2d across(-along.y(), along.x());
    for (std::size_t k = 1; k < done.updates.size(); ++k) {
      const SlamUpdate& update = done.updates[k];
      EXPECT_EQ(update.state, SlamState::weak);
      ASSERT_EQ(update.reason, SlamReason::degenerate);
      const double degrees = std::stod(update.detail.substr(update.detail.find(" at ") + 4));
      EXPECT_NEAR(std::remainder(degrees + heading * 180.0 / M_PI, 180.0), 0.0, 1.5) << update.detail;
      const Eigen::Matrix2d covariance = update.covariance->topLeftCorner<2, 2>();
      // The cells add the same in all directions.
      EXPECT_GT(along.dot(covariance * along) - across.dot(covariance * across), 1e-4);
      // Odometry, which is exact here, determines the motion along the corridor, so the robot is not kept from moving.
      EXPECT_LT(off(drive, k, update.world_from_body).x(), 0.03);
    }
  }
}

TEST(HectorSlam, TakesScansInTheirOrderWhenStampsGoBack) {
  const WalledDrive drive = room_drive(40);
  std::vector<Frame> frames = drive.frames();
  for (std::size_t k = 3; k + 1 < frames.size(); k += 5) std::swap(frames[k].stamp, frames[k + 1].stamp);
  const Driven done = run(frames, HectorOptions());
  ASSERT_EQ(done.trajectory.size(), frames.size());
  for (std::size_t k = 1; k < frames.size(); ++k) {
    EXPECT_LT(done.trajectory[k - 1].stamp, done.trajectory[k].stamp);
    EXPECT_EQ(done.updates[k].reason, SlamReason::none);
    EXPECT_LT(off(drive, k, done.updates[k].world_from_body).x(), 0.03);
  }
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const auto at = std::find_if(done.trajectory.begin(), done.trajectory.end(),
                                 [&](const StampedPose& pose) { return pose.stamp == frames[k].stamp; });
    ASSERT_NE(at, done.trajectory.end());
    EXPECT_LT(off(drive, k, at->world_from_body).x(), 0.03) << "the pose of the scan, not of its stamp";
  }
}

TEST(HectorSlam, AfterMissingScansANewSubmapBeginsWhosePoseIsUncertain) {
  const WalledDrive drive = ring_drive();
  std::vector<Frame> frames = drive.frames();
  frames.erase(frames.begin() + 40, frames.begin() + 75);
  const Driven done = run(frames, HectorOptions());
  const SlamUpdate &before = done.updates[39], &after = done.updates[40];
  ASSERT_EQ(after.reason, SlamReason::gap) << after.detail;
  EXPECT_EQ(after.state, SlamState::weak);
  EXPECT_GT((*after.covariance)(0, 0), 10.0 * (*before.covariance)(0, 0));
  EXPECT_THAT(after.events,
              ::testing::Contains(::testing::Field(&SlamEvent::detail, ::testing::HasSubstr("missing scans"))));
}

TEST(HectorSlam, ARepeatedStampIsReportedAndSkipped) {
  const WalledDrive drive = room_drive(12);
  std::vector<Frame> frames = drive.frames();
  frames.insert(frames.begin() + 6, frames[5]);
  const Driven done = run(frames, HectorOptions());
  EXPECT_EQ(done.updates[6].reason, SlamReason::repeated_frame);
  EXPECT_EQ(done.updates[6].world_from_body.translation(), done.updates[5].world_from_body.translation());
  EXPECT_EQ(done.trajectory.size(), 12U);
}

TEST(HectorSlam, ImpossibleOdometryIsNotUsed) {
  const WalledDrive drive = room_drive(40);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const SE2 there = *drive.frames()[20].odometry_from_body;
  const SE2 broken_rotation(SO2::from_angle(nan), there.translation());
  for (const SE2& odometry : {pose_of(30.0, -20.0, 2.0), pose_of(nan, 0.0, 0.0), broken_rotation}) {
    std::vector<Frame> frames = drive.frames();
    // For one scan only, so that it jumps twice: there and back.
    frames[20].odometry_from_body = odometry;
    const Driven done = run(frames, HectorOptions());
    EXPECT_EQ(done.updates[20].reason, SlamReason::odometry_jumped);
    EXPECT_EQ(done.updates[20].state, SlamState::tracking);
    EXPECT_EQ(done.updates[21].reason, SlamReason::odometry_jumped);
    EXPECT_EQ(done.updates[22].reason, SlamReason::none);
    EXPECT_LT(worst_error(drive, done.trajectory).x(), 0.02);
  }
}

TEST(HectorSlam, TheMotionIsExtrapolatedOverScansWithTooFewReturns) {
  const WalledDrive drive = room_drive(30);
  std::vector<Frame> frames = drive.frames();
  for (std::size_t beam = 19; beam < 360; ++beam) frames[10].scan->ranges[beam] = 0.0F;
  frames[12].scan.reset();
  const Driven done = run(frames, HectorOptions());
  EXPECT_EQ(done.updates[10].reason, SlamReason::few_returns);
  EXPECT_EQ(done.updates[10].state, SlamState::weak);
  EXPECT_EQ(done.updates[10].used, 19);
  EXPECT_THAT(done.updates[10].detail, ::testing::HasSubstr("needs at least 20 valid beams, got 19 of 360"));
  EXPECT_EQ(done.updates[12].reason, SlamReason::no_data);
  EXPECT_EQ(done.updates[13].reason, SlamReason::none);
  // From exact odometry.
  EXPECT_LT(worst_error(drive, done.trajectory).x(), 0.02);
  HectorOptions fewer;
  fewer.min_returns = 19;
  EXPECT_NE(run(frames, fewer).updates[10].reason, SlamReason::few_returns);
}

TEST(HectorSlam, WithoutAnyScanThereIsNoMapAndNoPose) {
  std::vector<Frame> frames = room_drive(5).frames();
  for (Frame& frame : frames) frame.scan.reset();
  const Driven done = run(frames, HectorOptions());
  for (const SlamUpdate& update : done.updates) EXPECT_EQ(update.state, SlamState::initializing);
  EXPECT_TRUE(done.trajectory.empty());
  EXPECT_EQ(grid_of(done).width, 0);
  EXPECT_TRUE(done.snapshot->keyframes.empty());
  EXPECT_TRUE(run({}, HectorOptions()).trajectory.empty());
}

TEST(HectorSlam, AnUnrelatedScanIsLostAndTheNextOneIsTrackedAgain) {
  const WalledDrive drive = room_drive(30);
  std::vector<Frame> frames = drive.frames();
  // All returns at half their range are in free space.
  for (float& range : frames[15].scan->ranges) range *= 0.5F;
  const Driven done = run(frames, HectorOptions());
  EXPECT_EQ(done.updates[15].state, SlamState::lost);
  EXPECT_EQ(done.updates[15].reason, SlamReason::poor_match);
  EXPECT_FALSE(done.updates[15].covariance);
  EXPECT_EQ(done.updates[16].state, SlamState::relocalized);
  EXPECT_EQ(done.updates[17].state, SlamState::tracking);
  EXPECT_LT(worst_error(drive, done.trajectory).x(), 0.02);
}

TEST(HectorSlam, GivesTheSameBytesForAnyNumberOfThreads) {
  WalledDrive drive = ring_drive();
  drive.measured_m = 1.02;
  const std::vector<Frame> frames = drive.frames();
  const Driven alone = run(frames, HectorOptions());
  TaskPool pool(2);
  const Driven together = run(frames, HectorOptions(), &pool);
  ASSERT_EQ(alone.trajectory.size(), together.trajectory.size());
  for (std::size_t k = 0; k < alone.trajectory.size(); ++k) {
    const Eigen::Matrix4d a = alone.trajectory[k].world_from_body.matrix();
    const Eigen::Matrix4d b = together.trajectory[k].world_from_body.matrix();
    EXPECT_EQ(std::memcmp(a.data(), b.data(), sizeof(double) * 16), 0) << k;
  }
  EXPECT_EQ(grid_of(alone).percent, grid_of(together).percent);
  EXPECT_EQ(alone.snapshot->constraints.size(), together.snapshot->constraints.size());
  EXPECT_GT(loops_around(*alone.snapshot), 0) << "there must be work for the threads";
}

TEST(HectorSlam, ASnapshotNeverChanges) {
  const std::vector<Frame> frames = room_drive(40).frames();
  HectorSlam slam(HectorOptions(), nullptr);
  for (std::size_t k = 0; k < 10; ++k) slam.process(frames[k]);
  const auto early = slam.snapshot();
  const auto percent = occupancy_grid_of(*early).value().percent;
  const std::size_t keyframes = early->keyframes.size();
  for (std::size_t k = 10; k < frames.size(); ++k) slam.process(frames[k]);
  slam.finish();
  EXPECT_EQ(occupancy_grid_of(*early).value().percent, percent);
  EXPECT_EQ(early->keyframes.size(), keyframes);
  EXPECT_GT(slam.snapshot()->keyframes.size(), keyframes);
  EXPECT_GT(slam.snapshot()->revision, early->revision);
}

}  // namespace
}  // namespace rastro
