// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/direct_alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "rastro/base/random.h"
#include "rastro/math/math_testing.h"

namespace rastro {
namespace {

using testing::pose_near;

Matrix6d some_covariance(Random& random, double sigma) {
  Matrix6d root;
  for (double& entry : root.reshaped()) entry = sigma * random.normal();
  return root * root.transpose() + 0.1 * sigma * sigma * Matrix6d::Identity();
}

double cost(const SE3& pose, const RelativePose& estimate) {
  const Vector6d off = (pose * estimate.camera_from_keyframe.inverse()).log();
  return off.dot(estimate.covariance.inverse() * off);
}

/// No other pose nearby has a smaller sum of both costs.
TEST(DirectAlignment, TheFusedPoseIsTheMostLikelyOne) {
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const RelativePose a{SE3::exp(0.3 * Vector6d::Ones()), some_covariance(random, 1e-4)};
    Vector6d off;
    for (double& entry : off) entry = 1e-4 * random.normal();
    const RelativePose b{SE3::exp(off) * a.camera_from_keyframe, some_covariance(random, 2e-4)};
    const RelativePose both = fused(a, b);
    const double least = cost(both.camera_from_keyframe, a) + cost(both.camera_from_keyframe, b);
    for (int k = 0; k < 6; ++k)
      for (const double step : {-1e-5, 1e-5}) {
        const SE3 beside = SE3::exp(step * Vector6d::Unit(k)) * both.camera_from_keyframe;
        EXPECT_GT(cost(beside, a) + cost(beside, b), least) << trial;
      }
    EXPECT_THAT(fused(b, a).camera_from_keyframe, pose_near(both.camera_from_keyframe, 1e-7, 1e-7));
    if (contradiction(a, b) > 1.0) continue;
    const Matrix6d expected = (a.covariance.inverse() + b.covariance.inverse()).inverse();
    EXPECT_LT((both.covariance - expected).norm(), 1e-6 * expected.norm());
  }
}

TEST(DirectAlignment, EstimatesThatContradictEachOtherAreAsUncertainAsThatShows) {
  const Matrix6d covariance = 1e-6 * Matrix6d::Identity();
  const RelativePose a{SE3(), covariance}, b{SE3(SO3(), {0.012, 0.0, 0.0}), covariance};
  EXPECT_NEAR(contradiction(a, b), 12.0, 1e-9);  // 144 sigmas squared, two variances, six directions
  const RelativePose both = fused(a, b);
  EXPECT_NEAR(both.covariance(0, 0), 12.0 * 0.5e-6, 1e-12);
  EXPECT_NEAR(both.camera_from_keyframe.translation().x(), 0.006, 1e-12);
}

struct Nothing : DirectView {
  std::size_t bytes() const override { return 7; }
};

TEST(DirectAlignment, OnlyTheNewestKeyframesAreKept) {
  DirectKeyframes keyframes(2);
  keyframes.add(3, std::make_shared<Nothing>());
  keyframes.add(5, nullptr);
  EXPECT_EQ(keyframes.find(5), nullptr);
  keyframes.add(6, std::make_shared<Nothing>());
  keyframes.add(8, std::make_shared<Nothing>());
  EXPECT_EQ(keyframes.find(3), nullptr);
  EXPECT_NE(keyframes.find(6), nullptr);
  EXPECT_NE(keyframes.find(8), nullptr);
  EXPECT_EQ(keyframes.bytes(), 14U);
}

}  // namespace
}  // namespace rastro
