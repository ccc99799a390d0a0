// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/frozen_odometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace rastro {
namespace {

using Kind = LandmarkAssociation::Kind;

constexpr TimeNs period = ns_per_second / 10;
const std::vector<LandmarkAssociation> fit{{Kind::landmark, 0, 3.0}, {Kind::landmark, 1, 2.0}};
const std::vector<LandmarkAssociation> off{{Kind::landmark, 0, 9.0}, {Kind::contradicting, 1, 40.0}};

Frame frame_at(int k, double odometry_x, float range, std::size_t beams = 100) {
  Frame frame;
  frame.index = k;
  frame.stamp = k * period;
  frame.odometry_from_body = SE2(SO2(), {odometry_x, 0.0});
  frame.scan.emplace();
  frame.scan->max_range = 20.0;
  frame.scan->ranges.assign(100, 5.0F);
  std::fill_n(frame.scan->ranges.begin(), beams, range);
  return frame;
}

void see(FrozenOdometry& odometry, const std::vector<LandmarkAssociation>& associations) {
  odometry.judge(associations);
  odometry.end_frame(associations);
}

/// A robot that drives for 10 frames, then 20 frames with the same odometry. Landmarks at these squared distances.
FrozenOdometry after_20_frames(float range_change, const std::vector<LandmarkAssociation>& seen,
                               const std::vector<LandmarkAssociation>& seen_before, std::size_t beams = 100) {
  FrozenOdometry odometry;
  for (int k = 0; k < 30; ++k) {
    odometry.add(
        frame_at(k, 0.05 * std::min(k, 9), k < 10 ? 5.0F : 5.0F + range_change * static_cast<float>(k - 9), beams));
    see(odometry, k < 12 ? seen_before : seen);
    EXPECT_TRUE(k > 11 || !odometry.frozen());
  }
  return odometry;
}

TEST(FrozenOdometry, ARobotThatStandsStillIsNone) {
  EXPECT_FALSE(after_20_frames(0.0F, {}, {}).frozen());
  EXPECT_FALSE(after_20_frames(0.0F, fit, fit).frozen());
  EXPECT_FALSE(after_20_frames(-0.05F, {{Kind::contradicting, 0, 100.0}}, fit, 30).frozen())
      << "somebody stands before it";
  EXPECT_FALSE(after_20_frames(0.0F, off, fit).frozen()) << "the scan is the same";
  EXPECT_FALSE(after_20_frames(-0.05F, off, off, 30).frozen()) << "the map was wrong before";
}

TEST(FrozenOdometry, ScansOrLandmarksThatMoveTell) {
  EXPECT_TRUE(after_20_frames(-0.05F, {}, {}).frozen());
  EXPECT_TRUE(after_20_frames(-0.05F, off, fit, 30).frozen());
}

TEST(FrozenOdometry, PeopleWhoWalkByDoNot) {
  FrozenOdometry odometry;
  for (int k = 0; k < 30; ++k) {
    Frame frame = frame_at(k, 1.0, 5.0F);
    for (std::size_t beam = 0; beam < 15; ++beam) frame.scan->ranges[(beam + static_cast<std::size_t>(k)) % 100] = 2.0F;
    odometry.add(frame);
    see(odometry, {});
    EXPECT_FALSE(odometry.frozen()) << k;
  }
}

TEST(FrozenOdometry, ItsFirstStepIsOfTheWholeTimeWhereNoLandmarkTold) {
  FrozenOdometry blind = after_20_frames(-0.05F, {}, {});
  EXPECT_TRUE(blind.lost());
  EXPECT_FALSE(blind.thaw());
  blind.add(frame_at(30, 1.5, 4.0F));
  ASSERT_TRUE(blind.thaw());
  EXPECT_NEAR(blind.thaw()->seconds, 2.1, 1e-9);
  EXPECT_EQ(blind.thaw()->share, 1.0);
  EXPECT_TRUE(blind.thaw()->frozen);
  EXPECT_FALSE(blind.frozen());
  see(blind, {});
  blind.add(frame_at(31, 1.55, 4.0F));
  EXPECT_FALSE(blind.thaw());
}

TEST(FrozenOdometry, LandmarksMayTellAPartOfIt) {
  FrozenOdometry odometry = after_20_frames(-0.05F, fit, fit);
  for (int k = 30; k < 50; ++k) {
    odometry.add(frame_at(k, 0.45, 4.0F));
    see(odometry, {});
    EXPECT_EQ(odometry.lost(), k >= 35) << k;
  }
  odometry.add(frame_at(50, 2.5, 3.0F));
  ASSERT_TRUE(odometry.thaw());
  EXPECT_NEAR(odometry.thaw()->seconds, 4.1, 1e-9);
  EXPECT_NEAR(odometry.thaw()->share, 2.1 / 4.1, 1e-9);
}

TEST(FrozenOdometry, WhereLandmarksToldItsFirstStepIsNone) {
  FrozenOdometry told = after_20_frames(-0.05F, fit, fit);
  told.add(frame_at(30, 1.5, 4.0F));
  EXPECT_TRUE(told.frozen());
  EXPECT_FALSE(told.thaw());
  see(told, {});
  told.add(frame_at(31, 1.55, 4.0F));
  EXPECT_FALSE(told.frozen());
}

TEST(FrozenOdometry, OdometryThatIsSlowerThanTheFramesIsBelievedAgain) {
  FrozenOdometry odometry = after_20_frames(-0.05F, fit, fit);
  ASSERT_TRUE(odometry.frozen());
  for (int k = 30; k < 40; ++k) {
    odometry.add(frame_at(k, 1.5 + 0.1 * (k / 2), 4.0F));
    EXPECT_EQ(odometry.frozen(), k == 30) << k;
    see(odometry, fit);
  }
}

TEST(FrozenOdometry, TheTimeBeforeTheBodyMovedIsNoPartOfTheMotion) {
  const std::vector<LandmarkAssociation> none;
  FrozenOdometry odometry;
  for (int k = 0; k < 80; ++k) {  // it stands from frame 9 to 60
    odometry.add(frame_at(k, 0.05 * std::min(k, 9), 5.0F - 0.05F * static_cast<float>(std::max(0, k - 60))));
    see(odometry, k <= 60 ? fit : none);
  }
  ASSERT_TRUE(odometry.frozen());
  odometry.add(frame_at(80, 1.5, 4.0F));
  ASSERT_TRUE(odometry.thaw());
  EXPECT_NEAR(odometry.thaw()->seconds, 7.1, 1e-9);
  EXPECT_NEAR(odometry.thaw()->share, 1.0, 1e-9);
}

}  // namespace
}  // namespace rastro
