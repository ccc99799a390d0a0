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

std::vector<PoseObservation> observations_of(const SE3& ground_truth, Random& random, int count, double stereo_share,
                                             double outlier_share) {
  std::vector<PoseObservation> seen;
  while (static_cast<int>(seen.size()) < count) {
    PoseObservation one;
    const double x = random.uniform(-0.8, 0.8), y = random.uniform(-0.5, 0.5), depth = random.uniform(3.0, 20.0);
    const Eigen::Vector3d p = depth * Eigen::Vector3d(x, y, 1.0);
    one.point = ground_truth.inverse() * p;
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

const SE3 ground_truth(SO3::exp({0.1, -0.3, 0.2}), {0.4, -0.2, 1.0});

TEST(PoseRefinement, ConvergesFromAPerturbedStartDespiteOutliers) {
  for (const double stereo_share : {0.0, 0.5, 1.0}) {
    Random random(1);
    const auto seen = observations_of(ground_truth, random, 300, stereo_share, 0.25);
    const SE3 start = SE3::exp(testing::random_twist(random, 0.1)) * ground_truth;
    const PoseRefinement refined = refine_pose(start, seen, stereo_options());
    EXPECT_THAT(refined.camera_from_world, pose_near(ground_truth, 0.02, 0.002));
    int true_lost = 0, false_kept = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const bool outlier = ((ground_truth * seen[i].point).hnormalized() - seen[i].ray).norm() > 0.03;
      false_kept += outlier && refined.is_inlier[i] != 0;
      true_lost += !outlier && refined.is_inlier[i] == 0;
    }
    EXPECT_EQ(false_kept, 0);
    EXPECT_LT(true_lost, 25) << "of 225, 5 % are beyond the bound by chance";
  }
}

/// Two groups that each fit a pose of their own: the initial value says which.
TEST(PoseRefinement, OutliersOfAGoodStartStayOutliers) {
  Random random(2);
  std::vector<PoseObservation> seen = observations_of(ground_truth, random, 100, 0.5, 0.0);
  const SE3 other = SE3::exp((Vector6d() << 0.6, 0.0, 0.0, 0.0, 0.0, 0.0).finished()) * ground_truth;
  const auto moved = observations_of(other, random, 160, 0.5, 0.0);
  seen.insert(seen.end(), moved.begin(), moved.end());
  PoseRefinementOptions options = stereo_options();
  const auto error = [&] {
    return (refine_pose(ground_truth, seen, options).camera_from_world * ground_truth.inverse()).log().norm();
  };
  EXPECT_GT(error(), 0.3) << "the larger one";
  options.starts_judged = true;
  options.rounds = 2;
  EXPECT_LT(error(), 0.02);
}

TEST(PoseRefinement, CovarianceIsConsistentWithThePoseError) {
  for (const double stereo_share : {0.0, 1.0}) {
    Random random(2);
    PoseRefinementOptions options = stereo_options();
    options.chi2_mono = options.chi2_stereo = 1e4;
    double sum = 0.0;
    constexpr int trials = 200;
    for (int trial = 0; trial < trials; ++trial) {
      const auto seen = observations_of(ground_truth, random, 60, stereo_share, 0.0);
      const PoseRefinement refined = refine_pose(ground_truth, seen, options);
      const Vector6d off = (ground_truth * refined.camera_from_world.inverse()).log();
      sum += off.dot(refined.covariance.ldlt().solve(off));
    }
    EXPECT_NEAR(sum / trials, 6.0, 0.8) << "chi squared with six degrees of freedom";
  }
}

/// Points that are wrong along a line each, as those of little parallax are, half of them by much.
TEST(PoseRefinement, UncertainPointsWeighLessAndCountInTheCovariance) {
  for (const double stereo_share : {0.0, 1.0}) {
    Random random(4);
    PoseRefinementOptions options = stereo_options();
    options.chi2_mono = options.chi2_stereo = 1e9;
    double sum = 0.0, squared = 0.0, squared_if_certain = 0.0;
    constexpr int trials = 200;
    for (int trial = 0; trial < trials; ++trial) {
      auto seen = observations_of(ground_truth, random, 60, stereo_share, 0.0);
      auto if_certain = seen;
      std::vector<Eigen::Matrix3d> covariances(seen.size());
      for (std::size_t i = 0; i < seen.size(); ++i) {
        const double depth = (ground_truth * seen[i].point).z();
        const Eigen::Vector3d line(random.normal(), random.normal(), random.normal());
        const Eigen::Vector3d sigma = (i % 2 == 0 ? 0.001 : 0.02) * depth * line;
        covariances[i] = sigma * sigma.transpose();
        seen[i].point += random.normal() * sigma;
        if_certain[i].point = seen[i].point;
        seen[i].point_covariance = &covariances[i];
      }
      const SE3 start = SE3::exp(testing::random_twist(random, 0.02)) * ground_truth;
      const PoseRefinement refined = refine_pose(start, seen, options);
      const Vector6d off = (ground_truth * refined.camera_from_world.inverse()).log();
      sum += off.dot(refined.covariance.ldlt().solve(off));
      squared += off.squaredNorm();
      const SE3 certain = refine_pose(start, if_certain, options).camera_from_world;
      squared_if_certain += (ground_truth * certain.inverse()).log().squaredNorm();
    }
    EXPECT_NEAR(sum / trials, 6.0, 0.8) << "chi squared with six degrees of freedom";
    EXPECT_LT(squared, 0.5 * squared_if_certain);
  }
}

TEST(PoseRefinement, NoStepFromTheResultFitsBetter) {
  Random random(3);
  const auto seen = observations_of(ground_truth, random, 50, 0.5, 0.0);
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
  const PoseRefinement refined =
      refine_pose(SE3::exp(testing::random_twist(random, 0.1)) * ground_truth, seen, options);
  ASSERT_EQ(refined.inliers, 50);
  const double best = cost(refined.camera_from_world);
  EXPECT_NEAR(refined.mean_squared, best / 50, 1e-9 * best);
  for (int axis = 0; axis < 12; ++axis) {
    Vector6d step = Vector6d::Zero();
    step[axis / 2] = axis % 2 == 0 ? 3e-5 : -3e-5;
    EXPECT_GT(cost(SE3::exp(step) * refined.camera_from_world), best) << axis;
  }
}

/// Without noise, a share of them with a right camera; depths in meters.
std::vector<PoseObservation> exact_observations(int count, double stereo_share, double nearest, double farthest) {
  Random random(7);
  std::vector<PoseObservation> seen;
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(-0.8, 0.8), y = random.uniform(-0.5, 0.5);
    const double depth = random.uniform(nearest, farthest);
    PoseObservation one;
    one.point = ground_truth.inverse() * Eigen::Vector3d(depth * x, depth * y, depth);
    one.ray = {x, y};
    if (i < stereo_share * count) one.right_x = x - baseline / depth;
    seen.push_back(one);
  }
  return seen;
}

/// One round of plain least squares, without anything else that helps convergence.
PoseRefinementOptions one_round(int iterations) {
  PoseRefinementOptions options = stereo_options();
  options.rounds = 1;
  options.iterations = iterations;
  options.chi2_mono = options.chi2_stereo = 1e9;
  return options;
}

TEST(PoseRefinement, OneRoundConverges) {
  for (const double stereo_share : {0.0, 0.5, 1.0}) {
    const auto seen = exact_observations(40, stereo_share, 3.0, 20.0);
    Random random(3);
    for (int trial = 0; trial < 5; ++trial) {
      const SE3 start = SE3::exp(testing::random_twist(random, 0.3)) * ground_truth;
      EXPECT_THAT(refine_pose(start, seen, one_round(10)).camera_from_world, pose_near(ground_truth, 1e-9, 1e-9));
    }
  }
}

TEST(PoseRefinement, StepsThatAreTooLargeAreUndone) {
  // From far behind, Gauss-Newton steps past the points, where no point is visible any more.
  for (const double stereo_share : {0.0, 1.0}) {
    for (const double back : {5.0, 10.0, 20.0}) {
      const auto seen = exact_observations(40, stereo_share, 3.0, 6.0);
      const SE3 start = SE3(SO3::exp({0.01, -0.02, 0.03}), {0.2, -0.1, back}) * ground_truth;
      EXPECT_THAT(refine_pose(start, seen, one_round(60)).camera_from_world, pose_near(ground_truth, 1e-9, 1e-9))
          << back;
    }
  }
}

TEST(PoseRefinement, ItStopsByItself) {
  Random random(8);
  const auto seen = observations_of(ground_truth, random, 100, 0.5, 0.0);
  const SE3 start = SE3::exp(testing::random_twist(random, 0.1)) * ground_truth;
  const PoseRefinement many = refine_pose(start, seen, one_round(500));
  int needed = 0;
  for (bool same = false; !same;
       same = refine_pose(start, seen, one_round(needed)).camera_from_world.matrix() == many.camera_from_world.matrix())
    ++needed;
  EXPECT_GT(needed, 1);
  EXPECT_LT(needed, 5) << "when a step gains next to nothing";
}

TEST(PoseRefinement, TheLastTwoRoundsAreLeastSquares) {
  Random random(9);
  auto seen = observations_of(ground_truth, random, 80, 0.5, 0.0);
  for (std::size_t i = 0; i < seen.size(); i += 8) seen[i].ray.x() += 7.0 * seen[i].sigma;
  PoseRefinementOptions options = stereo_options();
  options.rounds = 1;
  const PoseRefinement one = refine_pose(ground_truth, seen, options),
                       of_all = refine_pose(ground_truth, seen, one_round(10));
  EXPECT_EQ(one.camera_from_world.matrix(), of_all.camera_from_world.matrix()) << "outliers pull like the others";
  ASSERT_LT(one.inliers, 75);
  ASSERT_GT(one.inliers, 40);
  std::vector<PoseObservation> kept;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (one.is_inlier[i] != 0) kept.push_back(seen[i]);
  }
  const PoseRefinement of_kept = refine_pose(one.camera_from_world, kept, one_round(10));
  options.rounds = 2;
  const PoseRefinement two = refine_pose(ground_truth, seen, options);
  EXPECT_EQ(two.camera_from_world.matrix(), of_kept.camera_from_world.matrix());
}

TEST(PoseRefinement, AnOutlierIsWhatIsBeyondTheBound) {
  const PoseRefinementOptions options = stereo_options();
  for (const bool stereo : {false, true}) {
    for (const double beyond : {0.99, 1.01}) {
      auto seen = exact_observations(60, 0.5, 3.0, 6.0);
      // With such a large sigma that it does not move the pose.
      PoseObservation& one = seen[stereo ? 0 : seen.size() - 1];
      one.sigma *= 100.0;
      const double off = beyond * one.sigma * std::sqrt(stereo ? options.chi2_stereo : options.chi2_mono);
      if (stereo) {
        one.right_x += off;
      } else {
        one.ray.y() -= off;
      }
      const PoseRefinement refined = refine_pose(ground_truth, seen, options);
      EXPECT_EQ(refined.inliers, beyond < 1.0 ? 60 : 59);
      EXPECT_EQ(refined.is_inlier[stereo ? 0 : seen.size() - 1], beyond < 1.0 ? 1 : 0);
    }
  }
}

TEST(PoseRefinement, ThreeObservationsAreEnough) {
  const auto seen = exact_observations(20, 0.5, 3.0, 6.0);
  const SE3 start = SE3(SO3::exp({0.01, -0.01, 0.0}), {0.02, 0.0, 0.03}) * ground_truth;
  for (const std::size_t first : {std::size_t{0}, std::size_t{14}}) {  // with a right camera, and without
    const PoseRefinement refined = refine_pose(start, std::span(seen).subspan(first, 3), stereo_options());
    EXPECT_EQ(refined.inliers, 3);
    EXPECT_THAT(refined.camera_from_world, pose_near(ground_truth, 1e-6, 1e-6));
    EXPECT_EQ(refine_pose(start, std::span(seen).subspan(first, 2), stereo_options()).inliers, 0);
  }
}

TEST(PoseRefinement, APointBehindTheCameraIsAnOutlier) {
  auto seen = exact_observations(30, 0.5, 3.0, 6.0);
  // Its projection is the same, but the point is behind the camera.
  seen[4].point = ground_truth.inverse() * (-(ground_truth * seen[4].point));
  seen[20].point = ground_truth.inverse() * (-(ground_truth * seen[20].point));
  const PoseRefinement refined = refine_pose(ground_truth, seen, stereo_options());
  EXPECT_EQ(refined.inliers, 28);
  EXPECT_EQ(refined.is_inlier[4] + refined.is_inlier[20], 0);
  EXPECT_THAT(refined.camera_from_world, pose_near(ground_truth, 1e-6, 1e-6));
}

TEST(PoseRefinement, AnUndeterminedPoseKeepsTheStart) {
  Random random(4);
  const auto seen = observations_of(ground_truth, random, 20, 0.0, 0.0);
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
  const auto seen = observations_of(ground_truth, random, 200, 0.5, 0.2);
  const PoseRefinement first = refine_pose(SE3(), seen, stereo_options());
  const PoseRefinement second = refine_pose(SE3(), seen, stereo_options());
  EXPECT_EQ(first.camera_from_world.matrix(), second.camera_from_world.matrix());
  EXPECT_EQ(first.covariance, second.covariance);
}

}  // namespace
}  // namespace rastro
