// SPDX-License-Identifier: Apache-2.0
// Times without scans that tell a pose, and scans where nothing is mapped.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "rastro/slam/hector/hector_slam.h"
#include "rastro/slam/hector/hector_testing.h"

namespace rastro {
namespace {

using testing::pose_of;
using testing::ring_drive;
using testing::room_drive;
using testing::WalledDrive;

std::vector<SlamUpdate> updates_of(HectorSlam& slam, const std::vector<Frame>& frames) {
  std::vector<SlamUpdate> updates;
  for (const Frame& frame : frames) updates.push_back(slam.process(frame));
  return updates;
}

/// Without the scans of 21 m in the middle.
std::vector<Frame> corridor_with_a_gap() {
  WalledDrive drive;
  drive.walls.add({-50.0, -1.0}, {50.0, -1.0});
  drive.walls.add({-50.0, 1.0}, {50.0, 1.0});
  drive.reach_m = 6.0;
  drive.world_from_body = {pose_of(-40.0, 0.1, 0.0)};
  drive.go(pose_of(0.1, 0.0, 0.0), 20);
  drive.go(pose_of(0.6, 0.0, 0.0), 35);
  drive.go(pose_of(0.1, 0.0, 0.0), 20);
  std::vector<Frame> frames = drive.frames();
  frames.erase(frames.begin() + 21, frames.begin() + 55);
  return frames;
}
constexpr std::size_t after_gap = 21;

TEST(HectorGaps, ScansOfFewReturnsAreMissingOnes) {
  std::vector<Frame> frames = ring_drive().frames();
  for (std::size_t k = 40; k < 75; ++k) std::fill(frames[k].scan->ranges.begin(), frames[k].scan->ranges.end(), 0.0F);
  HectorSlam slam({}, nullptr);
  const std::vector<SlamUpdate> updates = updates_of(slam, frames);
  EXPECT_EQ(updates[74].reason, SlamReason::few_returns);
  ASSERT_EQ(updates[75].reason, SlamReason::gap) << updates[75].detail;
  EXPECT_EQ(updates[75].state, SlamState::weak);
  EXPECT_THAT(updates[75].detail, ::testing::HasSubstr("no usable scan for 3.6 s"));
  EXPECT_GT((*updates[75].covariance)(0, 0), 10.0 * (*updates[39].covariance)(0, 0));
}

TEST(HectorGaps, TheFirstKeyScanAfterOneKnowsItsUnobservableDirection) {
  const std::vector<Frame> frames = corridor_with_a_gap();
  HectorSlam slam({}, nullptr);
  const std::vector<SlamUpdate> updates = updates_of(slam, frames);
  ASSERT_EQ(updates[after_gap].reason, SlamReason::gap);
  const auto map = slam.snapshot();
  const auto key = std::find_if(map->keyframes.begin(), map->keyframes.end(),
                                [&](const Keyframe& each) { return each.frame == frames[after_gap].index; });
  ASSERT_NE(key, map->keyframes.end());
  const auto step = std::find_if(map->constraints.begin(), map->constraints.end(), [&](const Constraint& each) {
    return each.kind == ConstraintKind::odometry && each.from == key->id && each.to == key->id + 1;
  });
  ASSERT_NE(step, map->constraints.end());
  EXPECT_LT(step->information(0, 0), 0.2 * step->information(1, 1)) << "wheels may slip along the corridor";
}

TEST(HectorGaps, CountOnceInTheOneMapWithoutLoopClosing) {
  const std::vector<Frame> frames = corridor_with_a_gap();
  std::vector<double> variances;
  for (const bool loop_closing : {true, false}) {
    HectorOptions options;
    options.loop_closing = loop_closing;
    HectorSlam slam(options, nullptr);
    const std::vector<SlamUpdate> updates = updates_of(slam, frames);
    ASSERT_EQ(updates[after_gap].reason, SlamReason::gap);
    variances.push_back(updates[after_gap].covariance->coeff(0, 0));
  }
  EXPECT_NEAR(variances[1] / variances[0], 1.0, 0.05);
}

/// Without a gap: odometry leads to another room at once.
TEST(HectorGaps, AScanWhereNothingIsMappedIsWeakAndBeginsTheMapThere) {
  WalledDrive drive = room_drive(12);
  drive.walls.add_box(28.0, -2.1, 35.0, 2.9);
  drive.world_from_body.push_back(pose_of(30.0, -0.6, 0.3));
  drive.go(SE2::exp({0.06, 0.0, 0.04}), 3);
  HectorOptions options;
  options.max_speed_m_per_s = 1000.0;
  HectorSlam slam(options, nullptr);
  const std::vector<SlamUpdate> updates = updates_of(slam, drive.frames());
  EXPECT_EQ(updates[11].state, SlamState::tracking);
  EXPECT_EQ(updates[12].state, SlamState::weak);
  EXPECT_EQ(updates[12].reason, SlamReason::poor_match);
  EXPECT_THAT(updates[12].detail, ::testing::HasSubstr("something is mapped, got 0 of 360"));
  EXPECT_GT((*updates[12].covariance)(0, 0), 1.0) << "of odometry over 29 m";
  for (const std::size_t k : {13U, 14U, 15U}) EXPECT_EQ(updates[k].state, SlamState::tracking) << k;
}

}  // namespace
}  // namespace rastro
