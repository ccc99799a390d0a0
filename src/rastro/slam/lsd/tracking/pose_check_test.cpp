// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/pose_check.h"

#include <gtest/gtest.h>

namespace rastro {
namespace {

ImageAlignment good_alignment() {
  ImageAlignment good;
  good.rms = 1.0, good.overlap = 0.95, good.inlier_share = 0.95, good.region_share = good.alike_share = 1.0,
  good.points = 5000;
  good.covariance = Matrix6d::Identity() * 1e-6;
  good.failure = AlignmentFailure::none;
  return good;
}

PoseVerdict judged(const ImageAlignment& alignment, double jump_deg = 0.0) {
  return judge_pose(alignment, 1.0, jump_deg, LsdOptions());
}

TEST(PoseCheck, AJumpAloneIsNoDoubt) {
  EXPECT_EQ(judged(good_alignment()).grade, PoseGrade::tracking);
  EXPECT_EQ(judged(good_alignment(), 20.0).grade, PoseGrade::tracking);
}

TEST(PoseCheck, FewFittingPixelsAreNoDoubtWhereBothImagesShowTheSame) {
  // As a blurred image and a rolling shutter have, in every region of the image.
  ImageAlignment blurred = good_alignment();
  blurred.inlier_share = 0.55, blurred.region_share = 0.8;
  EXPECT_EQ(judged(blurred).grade, PoseGrade::tracking);
}

TEST(PoseCheck, APoseThatFitsInAPartOfTheImageIsWeakAndWithAJumpLost) {
  ImageAlignment hidden = good_alignment();
  hidden.region_share = 0.6;
  const PoseVerdict weak = judged(hidden), lost = judged(hidden, 5.0);
  EXPECT_EQ(weak.grade, PoseGrade::weak);
  EXPECT_EQ(weak.reason, SlamReason::poor_match);
  EXPECT_NE(weak.detail.find("60 %"), std::string::npos) << weak.detail;
  EXPECT_EQ(lost.grade, PoseGrade::lost);
  EXPECT_EQ(lost.reason, SlamReason::implausible_motion);
}

TEST(PoseCheck, WhatShowsSomethingElseIsLostHoweverWellItFits) {
  ImageAlignment elsewhere = good_alignment();
  elsewhere.alike_share = 0.1;
  const PoseVerdict verdict = judged(elsewhere);
  EXPECT_EQ(verdict.grade, PoseGrade::lost);
  EXPECT_EQ(verdict.detail, "10 % of the regions of the image show what the keyframe shows, need 50 %");
}

TEST(PoseCheck, AnUncertainPositionIsADoubtInMeanDistances) {
  ImageAlignment uncertain = good_alignment();
  uncertain.covariance.topLeftCorner<3, 3>() = Eigen::Matrix3d::Identity() * 0.02 * 0.02;
  EXPECT_EQ(judged(uncertain).reason, SlamReason::degenerate);
  EXPECT_EQ(judge_pose(uncertain, 0.5, 0.0, LsdOptions()).grade, PoseGrade::tracking);
}

TEST(PoseCheck, AFlatImageFitsEverythingAndIsLost) {
  ImageAlignment flat = good_alignment();
  flat.gain = 0.1;
  EXPECT_EQ(judged(flat).grade, PoseGrade::lost);
  flat.gain = 0.25;  // the exposure, halved twice
  EXPECT_EQ(judged(flat).grade, PoseGrade::tracking);
}

TEST(PoseCheck, AFailedAlignmentIsLostAndSaysWhy) {
  ImageAlignment failed = good_alignment();
  failed.failure = AlignmentFailure::low_overlap;
  const PoseVerdict verdict = judged(failed);
  EXPECT_EQ(verdict.grade, PoseGrade::lost);
  EXPECT_NE(verdict.detail.find("low overlap"), std::string::npos) << verdict.detail;
}

}  // namespace
}  // namespace rastro
