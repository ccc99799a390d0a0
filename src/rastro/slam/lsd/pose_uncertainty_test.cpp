// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/pose_uncertainty.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rastro {
namespace {

AlignedFrame aligned(std::int64_t keyframe, const SE3& world_from_camera, double sigma = 0.0, double sigma_rad = 0.0) {
  AlignedFrame frame;
  frame.keyframe = keyframe;
  frame.mean_inverse_depth = 1.0;
  frame.world_from_camera = world_from_camera;
  frame.alignment.covariance.topLeftCorner<3, 3>() = sigma * sigma * Eigen::Matrix3d::Identity();
  frame.alignment.covariance.bottomRightCorner<3, 3>() = sigma_rad * sigma_rad * Eigen::Matrix3d::Identity();
  return frame;
}

SE3 ahead(double meters) { return {SO3(), {meters, 0.0, 0.0}}; }

TEST(PoseUncertainty, TheAlignmentsCovarianceIsGivenInTheWorldsAxesAndUnit) {
  // Along the camera's axis, which is the world's x.
  AlignedFrame frame = aligned(0, SE3(SO3::exp({0.0, M_PI / 2.0, 0.0}), {5.0, 0.0, 0.0}));
  frame.alignment.covariance(2, 2) = 0.01;
  frame.unit = 2.0;
  const Matrix6d covariance = PoseUncertainty({}).of_frame(frame);
  EXPECT_NEAR(covariance(0, 0), 4.0 * 0.01, 1e-4);
  EXPECT_LT(covariance(2, 2), 1e-4);
}

/// One radian of the keyframe is one meter at a meter's distance.
TEST(PoseUncertainty, AnErrorOfTheKeyframesRotationMovesTheFramesInIt) {
  PoseUncertainty uncertainty({});
  AlignedFrame keyframe = aligned(0, ahead(1.0));
  keyframe.alignment.covariance(5, 5) = 0.0001;  // about z
  uncertainty.add(3, {1.0, 0.0, 0.0}, keyframe);
  const Matrix6d covariance = uncertainty.of_frame(aligned(3, ahead(11.0)));
  EXPECT_NEAR(covariance(1, 1), 100.0 * 0.0001, 1e-4);
  EXPECT_LT(covariance(0, 0), 1e-4);
  EXPECT_NEAR(covariance(1, 5), 10.0 * 0.0001, 1e-4) << "to the left by a rotation to the left";
}

TEST(PoseUncertainty, GrowsFromKeyframeToKeyframeWithTheScaleToo) {
  double along = 0.0;
  for (const double drift : {0.0, 0.01}) {
    PoseUncertainty uncertainty({.scale_drift = drift});
    uncertainty.set_known(0, Eigen::Vector3d::Zero());
    double before = 0.0;
    for (std::int64_t id = 0; id < 4; ++id) {
      const AlignedFrame frame = aligned(id, ahead(1.0 + static_cast<double>(id)), 0.01, 0.001);
      const Matrix6d covariance = uncertainty.of_frame(frame);
      EXPECT_GT(covariance.trace(), before);
      before = covariance.trace();
      uncertainty.add(id + 1, frame.world_from_camera.translation(), frame);
    }
    const double of_last = uncertainty.of_frame(aligned(4, ahead(4.0)))(0, 0);
    // Three drifts: over the last three meters, two and one.
    EXPECT_NEAR(of_last - along, drift == 0.0 ? of_last : (9.0 + 4.0 + 1.0) * drift * drift, 1e-9);
    along = of_last;
  }
}

TEST(PoseUncertainty, ASubmapThatWasJoinedIsAsUncertainAsWhatItWasJoinedTo) {
  PoseUncertainty uncertainty({});
  uncertainty.set_known(0, Eigen::Vector3d::Zero());
  uncertainty.add(1, {1.0, 0.0, 0.0}, aligned(0, ahead(1.0), 0.1));
  EXPECT_FALSE(uncertainty.knows(7)) << "it was made before the submaps were joined";
  uncertainty.join(7, {2.0, 0.0, 0.0}, 1, 0.04 * Matrix6d::Identity(), 0.0);
  ASSERT_TRUE(uncertainty.knows(7));
  const Matrix6d covariance = uncertainty.of_frame(aligned(7, ahead(2.0)));
  EXPECT_NEAR(covariance(0, 0), 0.01 + 0.04, 1e-4);
  EXPECT_NEAR(covariance(3, 3), 0.04, 1e-4);
}

TEST(PoseUncertainty, AKeyframeThatGoesOnIsAsCertainAsBefore) {
  PoseUncertainty uncertainty({.scale_drift = 0.01});
  uncertainty.set_known(0, Eigen::Vector3d::Zero());
  uncertainty.add(1, {1.0, 0.0, 0.0}, aligned(0, ahead(1.0), 0.01, 0.001));
  const Matrix6d before = uncertainty.of_frame(aligned(1, ahead(1.0)));
  uncertainty.add(1, {1.0, 0.0, 0.0}, aligned(1, ahead(1.0), 0.1, 0.1));
  EXPECT_EQ(uncertainty.of_frame(aligned(1, ahead(1.0))), before);
}

TEST(PoseUncertainty, DepthsThatErrAlikeAndTheirScaleCount) {
  const AlignedFrame frame = aligned(0, ahead(10.0), 0.1);
  const auto variance_of = [&](const DepthErrorModel& errors, int axis) {
    return PoseUncertainty(errors).of_frame(frame)(axis, axis);
  };
  const double common = 1e-6;
  EXPECT_NEAR(variance_of({}, 1), 0.01 + common, 1e-9);
  EXPECT_NEAR(variance_of({.alike = 4.0}, 1), 0.04 + common, 1e-9);
  EXPECT_NEAR(variance_of({.scale = 0.003}, 1), 0.01 + common, 1e-9) << "across the path";
  EXPECT_NEAR(variance_of({.scale = 0.003}, 0), 0.01 + common + 0.03 * 0.03, 1e-9) << "along it";
}

/// There and back: what is missing on the way out is missing on the way back, if the depths are as uncertain.
TEST(PoseUncertainty, MotionsThatAreTooShortAddUpAlongThePath) {
  PoseUncertainty uncertainty({.attenuation = 1.0});
  uncertainty.set_known(0, Eigen::Vector3d::Zero());
  const auto frame_of = [](std::int64_t keyframe, double x, double attenuation) {
    AlignedFrame frame = aligned(keyframe, ahead(x));
    frame.attenuation = attenuation;
    return frame;
  };
  const double common = uncertainty.of_frame(frame_of(0, 0.0, 0.01))(0, 0);
  EXPECT_NEAR(uncertainty.of_frame(frame_of(0, 10.0, 0.01))(0, 0) - common, 0.1 * 0.1, 1e-5);
  EXPECT_NEAR(uncertainty.of_frame(frame_of(0, 10.0, 0.01))(1, 1) - common, 0.0, 1e-5) << "across the path";
  uncertainty.add(1, {10.0, 0.0, 0.0}, frame_of(0, 10.0, 0.01));
  EXPECT_NEAR(uncertainty.of_frame(frame_of(1, 0.0, 0.01))(0, 0) - common, 0.0, 1e-5);
  EXPECT_NEAR(uncertainty.of_frame(frame_of(1, 0.0, 0.002))(0, 0) - common, 0.08 * 0.08, 1e-5);
}

}  // namespace
}  // namespace rastro
