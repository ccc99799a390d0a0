// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/pose_uncertainty.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rastro {
namespace {

ImageAlignment alignment_with(double sigma, double sigma_rad, const SE3& image_from_reference) {
  ImageAlignment alignment;
  alignment.image_from_reference = image_from_reference;
  alignment.covariance.topLeftCorner<3, 3>() = sigma * sigma * Eigen::Matrix3d::Identity();
  alignment.covariance.bottomRightCorner<3, 3>() = sigma_rad * sigma_rad * Eigen::Matrix3d::Identity();
  return alignment;
}

TEST(PoseUncertainty, TheAlignmentsCovarianceIsGivenInTheWorldsAxesAndUnit) {
  ImageAlignment alignment = alignment_with(0.0, 0.0, SE3());
  alignment.covariance(2, 2) = 0.01;                                               // along the camera's axis
  const SE3 world_from_camera(SO3::exp({0.0, M_PI / 2.0, 0.0}), {5.0, 0.0, 0.0});  // which is the world's x
  const Matrix6d covariance = PoseUncertainty().of_frame(0, 2.0, 1.0, world_from_camera, alignment);
  EXPECT_NEAR(covariance(0, 0), 4.0 * 0.01, 1e-4);
  EXPECT_LT(covariance(2, 2), 1e-4);
}

/// One radian of the keyframe is one meter at a meter's distance.
TEST(PoseUncertainty, AnErrorOfTheKeyframesRotationMovesTheFramesInIt) {
  PoseUncertainty uncertainty;
  Matrix6d of_keyframe = Matrix6d::Zero();
  of_keyframe(5, 5) = 0.0001;  // about z
  uncertainty.set(3, {1.0, 0.0, 0.0}, of_keyframe);
  const SE3 ten_meters_on(SO3(), {11.0, 0.0, 0.0});
  const Matrix6d covariance = uncertainty.of_frame(3, 1.0, 1.0, ten_meters_on, alignment_with(0.0, 0.0, SE3()));
  EXPECT_NEAR(covariance(1, 1), 100.0 * 0.0001, 1e-4);
  EXPECT_LT(covariance(0, 0), 1e-4);
  EXPECT_NEAR(covariance(1, 5), 10.0 * 0.0001, 1e-4) << "to the left by a rotation to the left";
}

TEST(PoseUncertainty, GrowsFromKeyframeToKeyframe) {
  PoseUncertainty uncertainty;
  uncertainty.set_known(0, Eigen::Vector3d::Zero());
  double before = 0.0;
  for (std::int64_t id = 0; id < 4; ++id) {
    const SE3 pose(SO3(), {static_cast<double>(id + 1), 0.0, 0.0});
    const Matrix6d covariance = uncertainty.of_frame(id, 1.0, 1.0, pose, alignment_with(0.01, 0.001, SE3()));
    EXPECT_GT(covariance.trace(), before);
    before = covariance.trace();
    uncertainty.set(id + 1, pose.translation(), covariance);
  }
}

}  // namespace
}  // namespace rastro
