// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/current_keyframe.h"

#include <gtest/gtest.h>

namespace rastro {
namespace {

ImageAlignment moved_by(double way, double sigma) {
  ImageAlignment alignment;
  alignment.image_from_reference = SE3(SO3::exp({0.0, 0.3, 0.0}), {0.0, way, 0.0});
  alignment.covariance = Matrix6d::Identity();
  alignment.covariance.topLeftCorner<3, 3>() = sigma * sigma / 3.0 * Eigen::Matrix3d::Identity();
  return alignment;
}

TEST(CurrentKeyframe, TheScaleIsToldByAMotionThatIsLongerThanItsError) {
  LsdOptions options;
  options.max_motion_error = 0.3;
  const CurrentKeyframe keyframe(options, nullptr, 0, nullptr, nullptr, 2.0, 0);
  EXPECT_TRUE(keyframe.tells_scale(moved_by(0.1, 0.029)));
  EXPECT_FALSE(keyframe.tells_scale(moved_by(0.1, 0.031)));
  EXPECT_TRUE(keyframe.tells_scale(moved_by(0.2, 0.031)));
  EXPECT_FALSE(keyframe.tells_scale(moved_by(0.0, 0.001))) << "a rotation alone";
}

}  // namespace
}  // namespace rastro
