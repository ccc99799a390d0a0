// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/scan_follower.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "rastro/registration/scan_to_map.h"
#include "rastro/slam/hector/hector_testing.h"

namespace rastro {
namespace {

using testing::pose_of;
using testing::room_drive;
using testing::WalledDrive;

/// A submap of a room in its first scan's frame, and a scan 20 frames later.
struct MappedRoom {
  HectorOptions options;
  WalledDrive drive = room_drive(40);
  Submap submap{options, SE2()};
  static constexpr std::size_t seen = 20;

  MappedRoom() {
    for (std::size_t k = 0; k < 40; k += 4)
      submap.insert(returns_of(drive.scan(k), options), drive.ground_truth(k), k / 4);
  }
  FollowedScan follow(const SE2& off, double sigma_m, double sigma_rad, bool trusted = true) {
    const ScanGuess guess{drive.ground_truth(seen) * off, sigma_m, sigma_rad, trusted};
    return ScanFollower(options).follow(submap, returns_of(drive.scan(seen), options).points, guess);
  }
  double error_m(const FollowedScan& followed) const {
    return (followed.local_from_body.translation() - drive.ground_truth(seen).translation()).norm();
  }
};

TEST(ScanFollower, AGoodGuessIsRefinedWithoutASearch) {
  MappedRoom room;
  const FollowedScan followed = room.follow(pose_of(0.05, -0.04, 0.02), 0.05, 0.02);
  EXPECT_FALSE(followed.searched);
  EXPECT_TRUE(followed.fits);
  EXPECT_LT(room.error_m(followed), 0.02);
  EXPECT_GT(followed.score, 0.8);
  EXPECT_FALSE(followed.unseen_direction);
  EXPECT_GT(followed.covariance.diagonal().minCoeff(), 0.0);
}

/// So far off that the gradient leads elsewhere.
TEST(ScanFollower, TheBetterOfGradientAndSearchCounts) {
  MappedRoom room;
  for (const bool trusted : {true, false}) {
    const FollowedScan followed = room.follow(pose_of(0.45, -0.3, 0.3), 0.5, 0.4, trusted);
    EXPECT_TRUE(followed.searched);
    ASSERT_TRUE(followed.fits);
    EXPECT_LT(room.error_m(followed), 0.03);
  }
}

/// The gradient alone leads elsewhere from there.
TEST(ScanFollower, TheSearchFindsWhatTheGradientCannot) {
  MappedRoom room;
  for (const SE2& off : {pose_of(0.35, -0.35, 0.45), pose_of(-0.3, 0.38, -0.45)}) {
    const std::vector<Eigen::Vector2d> points = returns_of(room.drive.scan(MappedRoom::seen), room.options).points;
    const auto alone =
        match_scan_to_map(room.submap.levels(), points, room.drive.ground_truth(MappedRoom::seen) * off, nullptr, {});
    ASSERT_TRUE(alone);
    ASSERT_LT(alone->score, room.options.min_score) << "nothing to search for";
    const FollowedScan followed = room.follow(off, 0.5, 0.5, false);
    EXPECT_TRUE(followed.searched);
    ASSERT_TRUE(followed.fits);
    EXPECT_LT(room.error_m(followed), 0.03);
  }
}

TEST(ScanFollower, AnUncertainGuessIsSearchedForEvenIfItFits) {
  MappedRoom room;
  const FollowedScan followed = room.follow(pose_of(0.02, 0.0, 0.0), 0.9, 0.9);
  EXPECT_TRUE(followed.searched);
  EXPECT_LT(room.error_m(followed), 0.02);
}

TEST(ScanFollower, AScanThatFitsNowhereKeepsTheGuess) {
  MappedRoom room;
  std::vector<Eigen::Vector2d> arc;
  for (int k = 0; k < 90; ++k) arc.emplace_back(0.4 * std::cos(0.05 * k), 0.4 * std::sin(0.05 * k));
  const ScanGuess guess{pose_of(0.5, 0.1, 0.2), 0.1, 0.1, true};
  room.options.min_score = 0.9;
  const FollowedScan followed = ScanFollower(room.options).follow(room.submap, arc, guess);
  EXPECT_TRUE(followed.searched);
  EXPECT_FALSE(followed.fits);
  EXPECT_EQ(followed.local_from_body.matrix(), guess.local_from_body.matrix());
}

/// A corridor without ends in sight, and a body that is somewhere else in each scan, if there is one.
struct BareCorridor {
  HectorOptions options;
  WalledDrive drive;
  Submap submap{options, SE2()};

  BareCorridor() {
    drive.walls.add_box(-40.0, -1.0, 40.0, 1.0);
    drive.reach_m = 6.0;
    drive.beams = 720;
    drive.world_from_body = {pose_of(0.0, 0.1, 0.0)};
    drive.go(pose_of(0.05, 0.0, 0.0), 30);
    for (std::size_t k = 0; k < 30; k += 4)
      submap.insert(returns_of(drive.scan(k), options), drive.ground_truth(k), k / 4);
  }
  /// Legs of half a meter in front of the robot.
  std::vector<Eigen::Vector2d> points_with_person(std::size_t k) const {
    std::vector<Eigen::Vector2d> points = returns_of(drive.scan(k), options).points;
    const auto middle = points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2);
    std::vector<Eigen::Vector2d> legs;
    for (int i = 0; i < 60; ++i) legs.emplace_back(0.6 + 0.02 * std::abs(i - 30) / 30.0, -0.3 + 0.01 * i);
    points.insert(middle, legs.begin(), legs.end());
    return points;
  }
};

TEST(ScanFollower, APersonWhoWalksByIsNoStructureOfABareCorridor) {
  BareCorridor corridor;
  const SE2 expected = corridor.drive.ground_truth(29);
  const ScanGuess guess{expected, 0.05, 0.05};
  const FollowedScan followed =
      ScanFollower(corridor.options).follow(corridor.submap, corridor.points_with_person(29), guess);
  ASSERT_TRUE(followed.fits);
  ASSERT_TRUE(followed.unseen_direction);
  EXPECT_GT(std::abs(followed.unseen_direction->x()), 0.99);
  EXPECT_NEAR(followed.local_from_body.translation().x(), expected.translation().x(), 0.005);
}

TEST(ScanFollower, OfAFewScansNothingTellsWhoWalks) {
  BareCorridor corridor;
  Submap young(corridor.options, SE2());
  young.insert(returns_of(corridor.drive.scan(0), corridor.options), SE2(), 0);
  const FollowedScan followed =
      ScanFollower(corridor.options).follow(young, corridor.points_with_person(0), ScanGuess{SE2(), 0.05, 0.05});
  ASSERT_TRUE(followed.fits);
  EXPECT_FALSE(followed.unseen_direction);
}

}  // namespace
}  // namespace rastro
