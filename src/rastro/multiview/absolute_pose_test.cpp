// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/absolute_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <limits>

#include "rastro/math/math_testing.h"
#include "rastro/multiview/scene_testing.h"

namespace rastro {
namespace {

using testing::pose_near;
using testing::two_view_scene;

AbsolutePoseOptions pose_options() { return {{{2.0, 0.999, 1000, 3}, 500.0}, 1.0, 20}; }

SE3 random_pose(Random& random) {
  return SE3::exp((Vector6d() << testing::random_vector<Eigen::Vector3d>(random, 1.0),
                   testing::random_vector<Eigen::Vector3d>(random, 0.3))
                      .finished());
}

TEST(PoseFromThree, OneOfThePosesIsTheTrueOneAndAllProjectToThePixels) {
  Random random(1);
  int found = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const auto scene = two_view_scene(random, random_pose(random), {.count = 3});
    const auto poses = pose_from_three(std::span<const Eigen::Vector3d, 3>(scene.points),
                                       std::span<const Eigen::Vector2d, 3>(scene.b));
    EXPECT_LE(poses.size(), 4U);
    double nearest = 1.0;
    for (const SE3& pose : poses) {
      nearest = std::min(nearest, (pose.inverse() * scene.second_from_first).log().norm());
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_LT(((pose * scene.points[i]).hnormalized() - scene.b[i]).norm(), 1e-4);
      }
    }
    found += nearest < 1e-6;
  }
  EXPECT_GE(found, 495);
}

TEST(PoseFromThree, PointsOnALineGiveNone) {
  const std::array<Eigen::Vector3d, 3> line{Eigen::Vector3d(0, 0, 5), {1, 0, 5}, {2, 0, 5}};
  const std::array<Eigen::Vector2d, 3> points{Eigen::Vector2d(0, 0), {0.2, 0}, {0.4, 0}};
  EXPECT_TRUE(pose_from_three(line, points).empty());
  const std::array<Eigen::Vector3d, 3> one{Eigen::Vector3d(0, 0, 5), {0, 0, 5}, {0, 0, 5}};
  EXPECT_TRUE(pose_from_three(one, points).empty());
}

TEST(EstimateAbsolutePose, IsExactWithoutNoiseOnDepthsAndOnAPlane) {
  for (const bool planar : {false, true}) {
    Random random(2);
    const auto scene = two_view_scene(random, random_pose(random), {.count = 30, .planar = planar});
    const auto fit = estimate_absolute_pose(scene.points, scene.b, pose_options());
    ASSERT_TRUE(fit);
    EXPECT_EQ(fit->inliers, 30);
    EXPECT_LT(fit->rms_px, 1e-8);
    EXPECT_THAT(fit->camera_from_world, pose_near(scene.second_from_first, 1e-8, 1e-8));
  }
}

TEST(EstimateAbsolutePose, IsRobustToNoiseAndFortyPercentOutliers) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const auto scene =
        two_view_scene(random, random_pose(random), {.count = 200, .noise_px = 0.5, .outlier_share = 0.4});
    const auto fit = estimate_absolute_pose(scene.points, scene.b, pose_options());
    ASSERT_TRUE(fit);
    EXPECT_THAT(fit->camera_from_world, pose_near(scene.second_from_first, 0.02, 0.002)) << "seed " << seed;
    int kept_false = 0, lost_true = 0;
    for (std::size_t i = 0; i < scene.b.size(); ++i) {
      kept_false += scene.is_outlier[i] && fit->is_inlier[i] != 0;
      lost_true += !scene.is_outlier[i] && fit->is_inlier[i] == 0;
    }
    EXPECT_LE(kept_false, 1);
    EXPECT_LE(lost_true, 2);
  }
}

TEST(EstimateAbsolutePose, WorksFarFromTheOrigin) {
  Random random(4);
  const auto scene = two_view_scene(random, random_pose(random), {.count = 50});
  const SE3 world_from_scene(SO3::exp({0.3, 1.0, -0.2}), {4000.0, -2000.0, 300.0});
  std::vector<Eigen::Vector3d> far;
  for (const auto& p : scene.points) far.push_back(world_from_scene * p);
  const auto fit = estimate_absolute_pose(far, scene.b, pose_options());
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->inliers, 50);
  EXPECT_THAT(fit->camera_from_world * world_from_scene, pose_near(scene.second_from_first, 1e-7, 1e-9));
}

TEST(EstimateAbsolutePose, AGoodGuessSavesSamplesAndABadOneDoesNoHarm) {
  Random random(5);
  const auto scene = two_view_scene(random, random_pose(random), {.count = 200, .noise_px = 0.3, .outlier_share = 0.2});
  const auto none = estimate_absolute_pose(scene.points, scene.b, pose_options());
  const auto good = estimate_absolute_pose(scene.points, scene.b, pose_options(), scene.second_from_first);
  const auto bad = estimate_absolute_pose(scene.points, scene.b, pose_options(), SE3(SO3(), {50.0, 0.0, 0.0}));
  ASSERT_TRUE(none && good && bad);
  EXPECT_LE(good->iterations, none->iterations);
  for (const auto& fit : {*none, *good, *bad}) {
    EXPECT_THAT(fit.camera_from_world, pose_near(scene.second_from_first, 0.02, 0.002));
  }
}

TEST(EstimateAbsolutePose, CovarianceAgreesWithThePoseError) {
  Random random(6);
  const SE3 ground_truth = random_pose(random);
  double sum = 0.0;
  constexpr int trials = 200;
  for (int trial = 0; trial < trials; ++trial) {
    const auto scene = two_view_scene(random, ground_truth, {.count = 60, .noise_px = 0.3});
    auto options = pose_options();
    options.huber_px = 10.0;
    const auto fit = estimate_absolute_pose(scene.points, scene.b, options);
    ASSERT_TRUE(fit);
    const Vector6d off = (ground_truth * fit->camera_from_world.inverse()).log();
    sum += off.dot(fit->covariance.ldlt().solve(off));
  }
  EXPECT_NEAR(sum / trials, 6.0, 1.0);  // chi squared with six degrees of freedom
}

TEST(EstimateAbsolutePose, TooFewOrRandomPointsGiveNone) {
  Random random(7);
  const auto scene = two_view_scene(random, random_pose(random), {.count = 3});
  EXPECT_FALSE(estimate_absolute_pose(scene.points, scene.b, pose_options()));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Eigen::Vector3d> no_points(20, Eigen::Vector3d(nan, 0.0, 1.0));
  const std::vector<Eigen::Vector2d> pixels(20, Eigen::Vector2d(0.1, 0.1));
  EXPECT_FALSE(estimate_absolute_pose(no_points, pixels, pose_options()));
  EXPECT_FALSE(estimate_absolute_pose(no_points, pixels, pose_options(), SE3()));
  const std::vector<Eigen::Vector3d> one_point(20, Eigen::Vector3d(0.5, 0.5, 5.0));
  EXPECT_FALSE(estimate_absolute_pose(one_point, pixels, pose_options()));
  EXPECT_FALSE(refine_absolute_pose(one_point, pixels, SE3(), pose_options()));
}

TEST(EstimateAbsolutePose, WeightsChooseBetweenTwoMotions) {
  Random random(9);
  const SE3 one = random_pose(random), other = random_pose(random);
  const auto many = two_view_scene(random, one, {.count = 70}), few = two_view_scene(random, other, {.count = 30});
  std::vector<Eigen::Vector3d> points = many.points;
  std::vector<Eigen::Vector2d> rays = many.b;
  points.insert(points.end(), few.points.begin(), few.points.end());
  rays.insert(rays.end(), few.b.begin(), few.b.end());
  std::vector<std::int32_t> weights(70, 100);
  weights.resize(100, 1000);
  const auto by_number = estimate_absolute_pose(points, rays, pose_options());
  const auto by_weight = estimate_absolute_pose(points, rays, pose_options(), std::nullopt, weights);
  ASSERT_TRUE(by_number && by_weight);
  EXPECT_THAT(by_number->camera_from_world, pose_near(one, 1e-6, 1e-6));
  EXPECT_THAT(by_weight->camera_from_world, pose_near(other, 1e-6, 1e-6));
  EXPECT_GE(by_weight->inliers, 30);
}

TEST(RefineAbsolutePose, ConvergesFromAPerturbedStartDespiteAFewOutliers) {
  Random random(8);
  const auto scene = two_view_scene(random, random_pose(random), {.count = 100, .outlier_share = 0.05});
  const SE3 start = SE3::exp((Vector6d() << 0.2, -0.2, 0.2, 0.02, -0.02, 0.02).finished()) * scene.second_from_first;
  const auto fit = refine_absolute_pose(scene.points, scene.b, start, pose_options());
  ASSERT_TRUE(fit);
  EXPECT_THAT(fit->camera_from_world, pose_near(scene.second_from_first, 0.01, 0.001));
}

TEST(EstimateAbsolutePose, SameSeedSameBits) {
  Random random(9);
  const auto scene = two_view_scene(random, random_pose(random), {.count = 100, .noise_px = 0.5, .outlier_share = 0.3});
  const auto first = estimate_absolute_pose(scene.points, scene.b, pose_options());
  const auto second = estimate_absolute_pose(scene.points, scene.b, pose_options());
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->camera_from_world.matrix(), second->camera_from_world.matrix());
  EXPECT_EQ(first->covariance, second->covariance);
}

}  // namespace
}  // namespace rastro
