// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/current_keyframe.h"

#include <gtest/gtest.h>

#include <memory>

#include "rastro/slam/lsd/tracking/alignment_testing.h"

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

TEST(CurrentKeyframe, ResidualsAreMeasuredByTheOptionsNoise) {
  testing::AlignmentRoom room;
  LsdOptions options;
  const RenderedFrame first = room.render({});
  const auto pyramid = std::make_shared<const Pyramid>(alignment_pyramid(first.gray, options.levels));
  auto reference = std::make_shared<AlignmentReference>();
  reference->build(*pyramid, testing::semi_dense_depth(first, 5.0, 0.02, 1), room.camera(), {options.levels, 5.0, 0});
  const CurrentKeyframe keyframe(options, nullptr, 0, pyramid, reference, 0.3, 10);
  const SE3 moved(SO3::exp({0.0, 0.01, 0.0}), {-0.03, 0.0, 0.01});
  const Pyramid image = alignment_pyramid(room.render(moved.inverse()).gray, options.levels);
  const double usual = keyframe.track(image, moved).rms;
  options.intensity_sigma *= 20.0;
  const double noisy = keyframe.track(image, moved).rms;
  EXPECT_GT(usual, 0.0);
  EXPECT_LT(noisy, 0.5 * usual);
}

}  // namespace
}  // namespace rastro
