// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/pose_refinement.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cstring>

#include "rastro/math/math_testing.h"
#include "rastro/optimize/bundle_testing.h"

namespace rastro {
namespace {

using testing::pose_near;

constexpr double baseline = 0.3;

std::vector<PoseObservation> observations_of(const SE3& truth, Random& random, int count, double stereo_share,
                                             double outlier_share) {
  std::vector<PoseObservation> seen;
  while (static_cast<int>(seen.size()) < count) {
    PoseObservation one;
    const double x = random.uniform(-0.8, 0.8), y = random.uniform(-0.5, 0.5), depth = random.uniform(3.0, 20.0);
    const Eigen::Vector3d p = depth * Eigen::Vector3d(x, y, 1.0);
    one.point = truth.inverse() * p;
    one.sigma = (seen.size() % 3 == 0 ? 1.44 : 1.0) / 500.0;
    const double off_x = one.sigma * random.normal(), off_y = one.sigma * random.normal();
    const double off_r = one.sigma * random.normal();
    one.ray = Eigen::Vector2d(x + off_x, y + off_y);
    if (random.uniform() < stereo_share) one.right_x = x - baseline / depth + off_r;
    if (random.uniform() < outlier_share) one.ray.x() += random.uniform(0.05, 0.3);
    seen.push_back(one);
  }
  return seen;
}

PoseRefinementOptions stereo_options() {
  PoseRefinementOptions options;
  options.baseline = baseline;
  return options;
}

const SE3 truth(SO3::exp({0.1, -0.3, 0.2}), {0.4, -0.2, 1.0});

TEST(PoseRefinement, ComesBackFromADisturbedStartInSpiteOfOutliers) {
  for (const double stereo_share : {0.0, 0.5, 1.0}) {
    Random random(1);
    const auto seen = observations_of(truth, random, 300, stereo_share, 0.25);
    const SE3 start = SE3::exp(testing::random_twist(random, 0.1)) * truth;
    const PoseRefinement refined = refine_pose(start, seen, stereo_options());
    EXPECT_THAT(refined.camera_from_world, pose_near(truth, 0.02, 0.002));
    int true_lost = 0, false_kept = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const bool outlier = ((truth * seen[i].point).hnormalized() - seen[i].ray).norm() > 0.03;
      false_kept += outlier && refined.is_inlier[i] != 0;
      true_lost += !outlier && refined.is_inlier[i] == 0;
    }
    EXPECT_EQ(false_kept, 0);
    EXPECT_LT(true_lost, 25) << "of 225, 5 % are beyond the bound by chance";
  }
}

TEST(PoseRefinement, CovarianceSaysHowFarThePoseIsOff) {
  for (const double stereo_share : {0.0, 1.0}) {
    Random random(2);
    PoseRefinementOptions options = stereo_options();
    options.chi2_mono = options.chi2_stereo = 1e4;
    double sum = 0.0;
    constexpr int trials = 200;
    for (int trial = 0; trial < trials; ++trial) {
      const auto seen = observations_of(truth, random, 60, stereo_share, 0.0);
      const PoseRefinement refined = refine_pose(truth, seen, options);
      const Vector6d off = (truth * refined.camera_from_world.inverse()).log();
      sum += off.dot(refined.covariance.ldlt().solve(off));
    }
    EXPECT_NEAR(sum / trials, 6.0, 0.8) << "chi squared with six degrees of freedom";
  }
}

TEST(PoseRefinement, NoStepFromTheResultFitsBetter) {
  Random random(3);
  const auto seen = observations_of(truth, random, 50, 0.5, 0.0);
  PoseRefinementOptions options = stereo_options();
  options.chi2_mono = options.chi2_stereo = 1e4;
  options.iterations = 50;
  const auto cost = [&](const SE3& pose) {
    double sum = 0.0;
    for (const PoseObservation& one : seen) {
      const Eigen::Vector3d p = pose * one.point;
      double squared = (p.hnormalized() - one.ray).squaredNorm();
      if (!std::isnan(one.right_x)) squared += std::pow((p.x() - baseline) / p.z() - one.right_x, 2);
      sum += squared / (one.sigma * one.sigma);
    }
    return sum;
  };
  const PoseRefinement refined = refine_pose(SE3::exp(testing::random_twist(random, 0.1)) * truth, seen, options);
  ASSERT_EQ(refined.inliers, 50);
  const double best = cost(refined.camera_from_world);
  EXPECT_NEAR(refined.mean_squared, best / 50, 1e-9 * best);
  for (int axis = 0; axis < 12; ++axis) {
    Vector6d step = Vector6d::Zero();
    step[axis / 2] = axis % 2 == 0 ? 3e-5 : -3e-5;
    EXPECT_GT(cost(SE3::exp(step) * refined.camera_from_world), best) << axis;
  }
}

TEST(PoseRefinement, WhatLeavesItOpenLeavesTheStart) {
  Random random(4);
  const auto seen = observations_of(truth, random, 20, 0.0, 0.0);
  const SE3 start(SO3(), {1.0, 2.0, 3.0});
  const auto same = [&](std::span<const PoseObservation> of) {
    const PoseRefinement refined = refine_pose(start, of, {});
    EXPECT_EQ(refined.inliers, 0);
    EXPECT_EQ(refined.is_inlier.size(), of.size());
    EXPECT_EQ(refined.camera_from_world.matrix(), start.matrix());
  };
  same({});
  same(std::span(seen).first(2));
  const std::vector<PoseObservation> one(20, seen[0]);
  same(one);
  std::vector<PoseObservation> behind = seen;
  for (PoseObservation& point : behind) point.point = start.inverse() * Eigen::Vector3d(0.0, 0.0, -5.0);
  same(behind);
  std::vector<PoseObservation> senseless = seen;
  for (PoseObservation& point : senseless) point.point.x() = std::numeric_limits<double>::quiet_NaN();
  same(senseless);
}

TEST(PoseRefinement, SameBitsTwice) {
  Random random(5);
  const auto seen = observations_of(truth, random, 200, 0.5, 0.2);
  const PoseRefinement first = refine_pose(SE3(), seen, stereo_options());
  const PoseRefinement second = refine_pose(SE3(), seen, stereo_options());
  EXPECT_EQ(first.camera_from_world.matrix(), second.camera_from_world.matrix());
  EXPECT_EQ(first.covariance, second.covariance);
}

}  // namespace
}  // namespace rastro
