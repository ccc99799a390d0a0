// SPDX-License-Identifier: Apache-2.0
// How far is searched, how uncertain a match is, and what a direction without surfaces changes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "rastro/registration/scan_to_map.h"
#include "rastro/slam/hector/hector_testing.h"
#include "rastro/slam/hector/scan_follower.h"

namespace rastro {
namespace {

using testing::pose_of;
using testing::room_drive;
using testing::WalledDrive;

/// A submap of a room in its first scan's frame, and a scan 20 frames later.
struct RoomToFollow {
  HectorOptions options;
  WalledDrive drive = room_drive(40);
  Submap submap{options, SE2()};
  SE2 ground_truth = drive.ground_truth(20);
  std::vector<Eigen::Vector2d> points = returns_of(drive.scan(20), options).points;

  RoomToFollow() {
    for (std::size_t k = 0; k < 40; k += 4)
      submap.insert(returns_of(drive.scan(k), options), drive.ground_truth(k), k / 4);
  }
  /// Surfaces count where the map has them.
  void map_points() {
    for (std::size_t k = 0; k < 5; ++k) submap.insert({ground_truth.translation(), points}, ground_truth, k);
  }
  FollowedScan follow(const SE2& off, double sigma_m, double sigma_rad, bool trusted = false) {
    return ScanFollower(options).follow(submap, points, {ground_truth * off, sigma_m, sigma_rad, trusted});
  }
  bool finds(const SE2& off, double sigma_m, double sigma_rad) {
    const FollowedScan followed = follow(off, sigma_m, sigma_rad);
    EXPECT_TRUE(followed.searched);
    return followed.fits && (followed.local_from_body.translation() - ground_truth.translation()).norm() < 0.03;
  }
};

/// The gradient alone leads elsewhere from there.
const SE2 far_off = pose_of(0.35, -0.35, 0.45);

TEST(ScanFollowerLimits, WhereTheGuessFitsBadlyAllIsSearchedHoweverSureItIs) {
  RoomToFollow room;
  for (const double sigma : {0.01, 0.5}) EXPECT_TRUE(room.finds(far_off, sigma, sigma)) << sigma;
}

TEST(ScanFollowerLimits, AnUncertainGuessThatFitsIsSearchedForWithinFourSigmas) {
  RoomToFollow room;
  room.options.min_score = 0.01;  // fits anywhere
  room.options.search_from_m = room.options.search_from_rad = 0.001;
  EXPECT_TRUE(room.finds(far_off, 0.1, 0.13));
  EXPECT_FALSE(room.finds(far_off, 0.02, 0.13));
  EXPECT_FALSE(room.finds(far_off, 0.1, 0.02));
  room.options.search_reach_m = 0.05;
  EXPECT_FALSE(room.finds(far_off, 0.1, 0.13)) << "and no farther than the reach";
}

TEST(ScanFollowerLimits, EitherSigmaAloneMakesAGuessUncertain) {
  RoomToFollow room;
  const double m = room.options.search_from_m, rad = room.options.search_from_rad;
  for (const auto& [sigma_m, sigma_rad, searched] :
       {std::tuple{m, rad, false}, {1.01 * m, rad, true}, {m, 1.01 * rad, true}, {0.5 * m, 0.5 * rad, false}})
    EXPECT_EQ(room.follow(SE2(), sigma_m, sigma_rad).searched, searched) << sigma_m << ' ' << sigma_rad;
}

/// As follow() says: the information of the scan, of the guess and a little of its own.
TEST(ScanFollowerLimits, TheCovarianceIsThatOfScanAndGuess) {
  RoomToFollow room;
  const SE2 off = pose_of(0.03, -0.02, 0.01);
  for (const bool trusted : {false, true}) {
    for (const bool unseen : {false, true}) {
      room.options.degenerate_ratio = unseen ? 10.0 : 1e-9;
      const FollowedScan followed = room.follow(off, 0.05, 0.02, trusted);
      ASSERT_FALSE(followed.searched);
      ASSERT_EQ(followed.unseen_direction.has_value(), unseen);
      ScanPrior prior;
      prior.pose = room.ground_truth * off;
      if (trusted) prior.information.diagonal() << 0.1 / (0.05 * 0.05), 0.1 / (0.05 * 0.05), 0.1 / (0.02 * 0.02);
      const auto fit =
          match_scan_to_map(room.submap.levels(), room.points, prior.pose, &prior, {room.options.match_iterations});
      ASSERT_TRUE(fit);
      Eigen::Matrix3d seen = fit->information;
      if (unseen) {
        Eigen::Vector3d direction(followed.unseen_direction->x(), followed.unseen_direction->y(), 0.0);
        ASSERT_NEAR(direction.norm(), 1.0, 1e-9);
        const Eigen::Matrix3d without = Eigen::Matrix3d::Identity() - direction * direction.transpose();
        seen = without * seen * without;
      }
      const Eigen::Matrix3d information = seen + prior.information + 1e-3 * Eigen::Matrix3d::Identity();
      const Eigen::Matrix3d expected = std::max(0.01, fit->residual_variance) * information.inverse();
      EXPECT_LT((followed.covariance - expected).norm(), 1e-9 * expected.norm()) << trusted << ' ' << unseen;
      EXPECT_EQ(followed.score, fit->score);
    }
  }
}

/// The share of surfaces across the weakest direction, found as the ratio from which on the direction is unseen.
double share_across(RoomToFollow& room) {
  double seen = 0.0, unseen = 1.1;
  for (int k = 0; k < 60; ++k) {
    room.options.degenerate_ratio = 0.5 * (seen + unseen);
    (room.follow(SE2(), 0.05, 0.02).unseen_direction ? unseen : seen) = room.options.degenerate_ratio;
  }
  return seen;
}

TEST(ScanFollowerLimits, TheGuessCountsAlongAWeakDirectionUpToThreeTimesTheRatio) {
  RoomToFollow room;
  const double share = share_across(room);
  ASSERT_GT(share, 0.05);
  ASSERT_LT(share, 1.0);
  const SE2 off = pose_of(0.06, -0.05, 0.0);
  const auto at_ratio = [&](double ratio, bool trusted) {
    room.options.degenerate_ratio = ratio;
    return room.follow(off, 1.0, 1.0, trusted).local_from_body.translation();
  };
  room.options.search_from_m = room.options.search_from_rad = 2.0;
  room.options.degenerate_ratio = 1.01 * share;
  const auto unseen = room.follow(off, 1.0, 1.0, true).unseen_direction;
  ASSERT_TRUE(unseen);
  const Eigen::Vector2d scan = at_ratio(share / 3.01, true);
  const Eigen::Vector2d guess = (room.ground_truth * off).translation();
  const double along = unseen->dot(guess - scan);
  ASSERT_GT(std::abs(along), 0.02);
  for (const auto& [ratio, weight] : {std::pair{1.01 * share, 1.0},
                                      {share / 1.5, 0.75},
                                      {share / 2.0, 0.5},
                                      {share / 2.5, 0.25},
                                      {share / 4.0, 0.0}}) {
    EXPECT_LT((at_ratio(ratio, true) - (scan + weight * along * *unseen)).norm(), 1e-6) << weight;
    EXPECT_LT((at_ratio(ratio, false) - scan).norm(), 2e-3) << "a guess that is not trusted never counts";
  }
}

TEST(ScanFollowerLimits, SurfacesAreReadFromNeighboringReturnsThatAreNotTooFarApart) {
  RoomToFollow room;
  // All points lie on lines along x; whether points of two lines make a surface across x depends on their distance.
  for (const double between : {0.4, 0.6}) {
    room.points.clear();
    for (int row = 0; row < 12; ++row)
      for (int k = 0; k < 2; ++k) room.points.emplace_back(1.0 + 0.005 * k, -3.0 + between * row);
    room.options.degenerate_ratio = 0.3;
    room.options.min_score = 0.0;
    room.map_points();
    const FollowedScan followed = room.follow(SE2(), 0.05, 0.02);
    ASSERT_TRUE(followed.fits);
    ASSERT_TRUE(followed.unseen_direction);
    const Eigen::Vector2d in_body = followed.local_from_body.rotation().inverse() * *followed.unseen_direction;
    // Below the gap the points are one wall along y; beyond it they are no surface at all.
    EXPECT_EQ(std::abs(in_body.y()) > 0.99, between < 0.5) << in_body.transpose();
  }
}

TEST(ScanFollowerLimits, AGuessThatCountsInPartMakesThePoseUncertainAsItself) {
  RoomToFollow room;
  const double share = share_across(room), sigma_m = 0.2;
  const SE2 off = pose_of(0.06, -0.05, 0.0);
  room.options.search_from_m = room.options.search_from_rad = 2.0;
  const auto at_ratio = [&](double ratio, bool trusted) {
    room.options.degenerate_ratio = ratio;
    return room.follow(off, sigma_m, 1.0, trusted);
  };
  const Eigen::Vector2d direction = at_ratio(1.01 * share, true).unseen_direction.value();
  const Eigen::Vector2d across(-direction.y(), direction.x());
  const FollowedScan by_scan = at_ratio(share / 3.01, true);
  const double between = direction.dot((room.ground_truth * off).translation() - by_scan.local_from_body.translation());
  for (const double weight : {0.25, 0.5, 0.75}) {
    const FollowedScan followed = at_ratio(share / (3.0 - 2.0 * weight), true);
    EXPECT_FALSE(followed.unseen_direction);
    const Eigen::Matrix2d added = followed.guess_covariance.topLeftCorner<2, 2>();
    EXPECT_NEAR(direction.dot(added * direction),
                weight * sigma_m * sigma_m + weight * (1.0 - weight) * between * between, 1e-6);
    EXPECT_NEAR(across.dot(added * across), 0.0, 1e-9);
    EXPECT_EQ(at_ratio(share / (3.0 - 2.0 * weight), false).guess_covariance.norm(), 0.0) << "it does not count";
  }
  EXPECT_EQ(by_scan.guess_covariance.norm(), 0.0);
  EXPECT_EQ(at_ratio(1.01 * share, true).guess_covariance.norm(), 0.0) << "the covariance has it already";
}

TEST(ScanFollowerLimits, WhereNothingIsMappedAScanFitsButItsPoseIsTheGuess) {
  RoomToFollow room;
  const FollowedScan followed = room.follow(pose_of(40.0, 0.0, 0.0), 0.1, 0.04, true);
  EXPECT_TRUE(followed.fits);
  EXPECT_TRUE(followed.unmapped);
  EXPECT_EQ(followed.mapped, 0);
  EXPECT_FALSE(followed.sees_all_directions);
  EXPECT_EQ(followed.local_from_body.matrix(), (room.ground_truth * pose_of(40.0, 0.0, 0.0)).matrix());
  EXPECT_GT(followed.covariance(0, 0), 0.1 * 0.1);
}

TEST(ScanFollowerLimits, AMatchNeedsAsManyReturnsInMappedSpaceAsAPose) {
  RoomToFollow room;
  const std::vector<Eigen::Vector2d> points = room.points;
  for (const int mapped : {19, 20}) {
    for (std::size_t i = 0; i < points.size(); ++i)
      room.points[i] = points[i] + Eigen::Vector2d(i < static_cast<std::size_t>(mapped) ? 0.0 : 100.0, 0.0);
    const FollowedScan followed = room.follow(SE2(), 0.05, 0.02, true);
    EXPECT_TRUE(followed.fits);
    EXPECT_EQ(followed.mapped, mapped);
    EXPECT_EQ(followed.unmapped, mapped < room.options.min_returns);
  }
}

/// Two thirds of the returns in unknown space, which counts a half, the others where it is free.
TEST(ScanFollowerLimits, UnknownSpaceDoesNotMakeUpForAMatchThatContradictsTheMap) {
  RoomToFollow room;
  Submap submap(room.options, SE2());
  for (std::size_t k = 0; k < 2; ++k)
    submap.insert(returns_of(room.drive.scan(20), room.options), room.ground_truth, k);
  std::vector<Eigen::Vector2d> points;
  for (int k = 0; k < 360; ++k) {
    const double range_m = k % 20 < 7 ? 0.4 : 100.0, angle = k * M_PI / 180.0;
    points.emplace_back(range_m * std::cos(angle), range_m * std::sin(angle));
  }
  const FollowedScan followed =
      ScanFollower(room.options).follow(submap, points, {room.ground_truth, 0.05, 0.02, true});
  EXPECT_EQ(followed.mapped, 126);
  EXPECT_GT(followed.score, room.options.min_score);
  EXPECT_FALSE(followed.fits);
  EXPECT_EQ(followed.local_from_body.matrix(), room.ground_truth.matrix());
}

/// Half of the returns end in free space.
TEST(ScanFollowerLimits, AfterALossAPoseMustAgreeClearly) {
  RoomToFollow room;
  for (std::size_t i = 0; i < room.points.size(); i += 2) room.points[i] *= 0.5;
  ScanGuess guess{room.ground_truth, 0.05, 0.02};
  const auto follow = [&] { return ScanFollower(room.options).follow(room.submap, room.points, guess); };
  const FollowedScan usual = follow();
  ASSERT_GT(usual.score, room.options.min_score);
  ASSERT_LT(usual.score, room.options.loop_min_score);
  EXPECT_TRUE(usual.fits);
  guess.after_loss = true;
  EXPECT_FALSE(follow().fits);
  EXPECT_EQ(follow().needs, room.options.loop_min_score);
  EXPECT_EQ(follow().local_from_body.matrix(), guess.local_from_body.matrix());
  guess.after_gap = true;
  EXPECT_TRUE(follow().fits) << "what comes is mapped apart";
}

TEST(ScanFollowerLimits, AfterALossAllThatTheGuessAllowsIsSearched) {
  RoomToFollow room;
  ScanGuess guess{room.ground_truth * pose_of(0.7, 0.0, 1.0), 0.25, 0.3};
  guess.after_loss = true;
  const FollowedScan followed = ScanFollower(room.options).follow(room.submap, room.points, guess);
  ASSERT_TRUE(followed.fits);
  EXPECT_LT((followed.local_from_body.translation() - room.ground_truth.translation()).norm(), 0.03);
}

}  // namespace
}  // namespace rastro
