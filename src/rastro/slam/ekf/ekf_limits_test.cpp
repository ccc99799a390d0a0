// SPDX-License-Identifier: Apache-2.0
// Wrong stamps, and what EKF-SLAM takes of memory.
#include <gtest/gtest.h>

#include <cmath>

#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/map/scans/scan_layer.h"
#include "rastro/slam/ekf/ekf_slam.h"

namespace rastro {
namespace {

/// Straight ahead at 0.1 m a frame, with a landmark at (5, 1).
Frame frame_at(std::int64_t index, TimeNs later = 0) {
  Frame frame;
  frame.index = index;
  frame.stamp = 1'000'000'000 + index * 100'000'000 + later;
  const double x = 0.1 * static_cast<double>(index);
  frame.odometry_from_body = SE2(SO2(), {x, 0.0});
  frame.landmarks.push_back({3, std::hypot(5.0 - x, 1.0), std::atan2(1.0, 5.0 - x)});
  return frame;
}

TEST(EkfLimits, AStampFarAheadCostsOneFrame) {
  EkfSlam slam(EkfOptions(), false);
  for (int k = 0; k < 20; ++k) {
    const SlamUpdate update = slam.process(frame_at(k, k == 8 ? 4000 * ns_per_second : 0));
    EXPECT_EQ(update.reason == SlamReason::gap, k == 8) << k;
    EXPECT_EQ(update.state == SlamState::weak, k == 8) << k;
    EXPECT_NEAR(slam.filter().world_from_body().translation().x(), 0.1 * (k == 8 ? 7 : k), 1e-6) << k;
  }
  EXPECT_EQ(slam.trajectory().size(), 19U);
}

/// Far in the future, and zero.
TEST(EkfLimits, AWrongFirstStampCostsOneFrame) {
  for (const TimeNs off : {4000 * ns_per_second, -frame_at(0).stamp}) {
    constexpr TimeNs later = 1000 * ns_per_second;  // that of the other frames, so that zero is far from them
    EkfSlam slam(EkfOptions(), false);
    for (int k = 0; k < 20; ++k) {
      const SlamUpdate update = slam.process(frame_at(k, k == 0 ? off : later));
      EXPECT_EQ(update.state == SlamState::weak, k == 1) << k;
      EXPECT_NEAR(slam.filter().world_from_body().translation().x(), 0.1 * (k == 1 ? 0 : k), 1e-6) << k;
    }
    const Trajectory trajectory = slam.trajectory();
    ASSERT_EQ(trajectory.size(), 19U);
    EXPECT_EQ(trajectory.front().stamp, off > 0 ? frame_at(0, later).stamp : 0);
    const std::shared_ptr<const Map> map = slam.snapshot();
    EXPECT_EQ(map->keyframes.front().stamp, trajectory.front().stamp);
    EXPECT_EQ(map->sessions.front().first_stamp, trajectory.front().stamp);
    for (std::size_t i = 1; i < trajectory.size(); ++i) EXPECT_GT(trajectory[i].stamp, trajectory[i - 1].stamp);
  }
}

TEST(EkfLimits, ALongPauseCostsOneFrame) {
  EkfSlam slam(EkfOptions(), false);
  for (int k = 0; k < 20; ++k) {
    const SlamUpdate update = slam.process(frame_at(k, k >= 8 ? 4000 * ns_per_second : 0));
    EXPECT_EQ(update.reason == SlamReason::gap, k == 8) << k;
  }
  EXPECT_EQ(slam.trajectory().size(), 19U);
  EXPECT_NEAR(slam.filter().world_from_body().translation().x(), 1.9, 1e-6);
}

TEST(EkfLimits, AStandstillTakesTheMemoryOfItsPosesAlone) {
  EkfOptions options;
  options.corners = options.spikes = false;
  EkfSlam slam(options, true);
  std::size_t after_100 = 0;
  for (int k = 0; k < 1000; ++k) {
    Frame frame = frame_at(0, k * ns_per_second / 10);
    frame.index = k;
    frame.scan.emplace();
    frame.scan->angle_step = 0.01;
    frame.scan->max_range = 20.0;
    frame.scan->ranges.assign(180, 5.0F);
    slam.process(frame);
    if (k == 99) after_100 = slam.map_memory().bytes;
  }
  EXPECT_LE(slam.map_memory().bytes, after_100 + 900 * (sizeof(StampedPose) + sizeof(KeyframeId)));
  EXPECT_TRUE(slam.snapshot()->layer<ScanLayer>());
}

TEST(EkfLimits, LandmarksStayWithinTheBudgetWithTheMemoryThatIsHeldForThem) {
  constexpr std::size_t budget = 200'000;
  EkfOptions options;
  options.observations = 1;
  EkfSlam slam(options, false, {}, budget);
  for (int k = 0; k < 40; ++k) {
    Frame frame = frame_at(k);
    for (int i = 0; i < 10; ++i) frame.landmarks.push_back({10 * k + i + 10, 3.0 + 0.5 * i, 0.1 * i});
    slam.process(frame);
    EXPECT_LT(slam.map_memory().bytes, budget) << k;
  }
  EXPECT_LE(slam.filter().bytes(), budget / 10 * 9);
  EXPECT_GT(slam.filter().landmarks(), 60U);
  EXPECT_LT(slam.filter().landmarks(), 80U);
  const auto events = slam.finish();
  ASSERT_FALSE(events.empty());
  EXPECT_NE(events[0].detail.find("memory has room for"), std::string::npos) << events[0].detail;
}

TEST(EkfLimits, TheLastTwentiethOfTheLandmarksAreCandidates) {
  EkfOptions options;
  options.observations = 1, options.max_landmarks = 20;
  EkfSlam slam(options, false);
  Frame frame = frame_at(0);
  for (int i = 0; i < 30; ++i) frame.landmarks.push_back({i + 10, 3.0 + i, 0.0});
  slam.process(frame);
  EXPECT_EQ(slam.filter().landmarks(), 20U);
  EXPECT_EQ(slam.snapshot()->layer<LandmarkLayer>()->landmarks.size(), 19U);
  EXPECT_EQ(slam.finish().size(), 1U);
}

}  // namespace
}  // namespace rastro
