// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/scan_gap.h"

#include <gtest/gtest.h>

#include "rastro/slam/hector/hector_testing.h"

namespace rastro {
namespace {

using testing::pose_of;

FollowedScan fitted(const SE2& pose, double score) { return {.local_from_body = pose, .score = score, .fits = true}; }

TEST(ScanGap, IsWhereTimePassedAndLittleWasMappedBefore) {
  const ScanGuess guess{pose_of(1.0, 2.0, 0.5), 0.1, 0.1, true};
  const SE2& pose = guess.local_from_body;
  EXPECT_FALSE(gap_before(0.0, guess, fitted(pose, 0.5)));
  EXPECT_FALSE(gap_before(4.0, guess, fitted(pose, 0.75))) << "the match tells the pose";
  EXPECT_FALSE(gap_before(4.0, guess, {.local_from_body = pose, .score = 0.3}));
  ASSERT_TRUE(gap_before(4.0, guess, fitted(pose, 0.74)));
  EXPECT_EQ(gap_before(4.0, guess, fitted(pose, 0.74))->seconds, 4.0);
}

TEST(ScanGap, LeavesWhatTheGuessMayBeWrongByAndNoLessThanTimeDoes) {
  const SE2 pose = pose_of(1.0, 2.0, 0.5);
  const auto diagonal = [&](double sigma_m, double sigma_rad) -> Eigen::Vector3d {
    return gap_before(4.0, {pose, sigma_m, sigma_rad, true}, fitted(pose, 0.5))->covariance.diagonal();
  };
  EXPECT_LT((diagonal(0.5, 0.3) - Eigen::Vector3d(0.25, 0.25, 0.09)).norm(), 1e-12);
  EXPECT_LT((diagonal(0.01, 0.001) - Eigen::Vector3d(0.04, 0.04, 0.0004)).norm(), 1e-12);
}

/// Where the match leads away from the guess, one of both is wrong.
TEST(ScanGap, LeavesWhatMatchAndGuessDisagreeBy) {
  const ScanGuess guess{pose_of(1.0, 2.0, 3.1), 0.5, 0.3, true};
  const auto gap = gap_before(4.0, guess, fitted(pose_of(1.3, 1.6, 3.1 + 0.1), 0.5));
  ASSERT_TRUE(gap);
  const Eigen::Vector3d moved(0.3, -0.4, 0.1);
  Eigen::Matrix3d expected = Eigen::Vector3d(0.25, 0.25, 0.09).asDiagonal();
  expected += moved * moved.transpose();
  EXPECT_LT((gap->covariance - expected).norm(), 1e-9);
}

}  // namespace
}  // namespace rastro
