// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/view_correlation.h"

#include <gtest/gtest.h>

#include "rastro/slam/lsd/tracking/alignment_testing.h"

namespace rastro {
namespace {

class ViewCorrelation : public ::testing::Test {
 protected:
  ViewCorrelation() {
    const RenderedFrame frame = room_.render(SE3());
    reference_.build(alignment_pyramid(frame.gray, 1), testing::semi_dense_depth(frame, 5.0, 0.0, 1), room_.camera());
  }
  double share_of(const GrayImage& image, const SE3& image_from_reference) const {
    const Pyramid pyramid = alignment_pyramid(image, 1);
    return correlated_share(reference_.level(0), pyramid.level(0), image_from_reference, {}, 0.5);
  }

  testing::AlignmentRoom room_;
  AlignmentReference reference_;
};

TEST_F(ViewCorrelation, IsHighAtTheRightPoseWhateverTheExposure) {
  const SE3 image_from_reference(SO3::exp({0.01, -0.02, 0.005}), {0.05, 0.0, -0.05});
  const GrayImage image = room_.render(image_from_reference.inverse()).gray;
  EXPECT_GT(share_of(image, image_from_reference), 0.9);
  EXPECT_GT(share_of(testing::exposed(image, 0.5, 20.0, 3.0, 1), image_from_reference), 0.9);
}

TEST_F(ViewCorrelation, IsLowAtAWrongPoseAndWhereTheImageShowsSomethingElse) {
  const GrayImage image = room_.render(SE3()).gray;
  EXPECT_LT(share_of(image, SE3(SO3::exp({0.0, 0.2, 0.0}), Eigen::Vector3d::Zero())), 0.2);
  const SE3 elsewhere(SO3::exp({0.0, 0.5, 0.1}), {0.3, -0.2, 0.8});
  EXPECT_LT(share_of(room_.render(elsewhere).gray, SE3()), 0.2);
}

TEST_F(ViewCorrelation, NothingIsAlikeInABlankImageOrOutOfView) {
  EXPECT_EQ(share_of(GrayImage(320, 240), SE3()), 0.0);
  EXPECT_EQ(share_of(room_.render(SE3()).gray, SE3(SO3::exp({0.0, 2.0, 0.0}), Eigen::Vector3d::Zero())), 0.0);
}

}  // namespace
}  // namespace rastro
