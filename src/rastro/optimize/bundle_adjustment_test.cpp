// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/bundle_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cstring>

#include "rastro/math/math_testing.h"
#include "rastro/optimize/bundle_testing.h"

namespace rastro {
namespace {

using testing::bundle_scene;
using testing::BundleScene;
using testing::BundleSceneOptions;
using testing::pose_near;

/// The same residual with Ceres' automatic derivatives: camera as angle-axis and translation.
struct Reprojection {
  BundleObservation seen;
  double baseline;

  template <typename T>
  bool operator()(const T* camera, const T* point, T* error) const {
    T p[3];
    ceres::AngleAxisRotatePoint(camera, point, p);
    for (int k = 0; k < 3; ++k) p[k] += camera[3 + k];
    error[0] = (p[0] / p[2] - seen.ray.x()) / seen.sigma;
    error[1] = (p[1] / p[2] - seen.ray.y()) / seen.sigma;
    error[2] = std::isnan(seen.right_x) ? T(0.0) : ((p[0] - baseline) / p[2] - seen.right_x) / seen.sigma;
    return true;
  }
};

/// Ceres' solution of a bundle: poses, points, and the final cost.
double adjust_with_ceres(Bundle& bundle, const BundleOptions& options) {
  std::vector<std::array<double, 6>> cameras;
  for (const SE3& pose : bundle.camera_from_world) {
    const Eigen::Vector3d rotation = pose.rotation().log(), t = pose.translation();
    cameras.push_back({rotation.x(), rotation.y(), rotation.z(), t.x(), t.y(), t.z()});
  }
  ceres::Problem problem;
  for (const BundleObservation& seen : bundle.observations) {
    const double width = std::isnan(seen.right_x) ? options.huber_mono : options.huber_stereo;
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Reprojection, 3, 6, 3>(new Reprojection{seen, bundle.baseline}),
        width > 0.0 ? new ceres::HuberLoss(width) : nullptr, cameras[seen.camera].data(),
        bundle.points[seen.point].data());
  }
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (bundle.fixed[i] != 0 && problem.HasParameterBlock(cameras[i].data()))
      problem.SetParameterBlockConstant(cameras[i].data());
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.max_num_iterations = 200;
  solver.function_tolerance = 1e-14;
  solver.parameter_tolerance = 1e-14;
  solver.gradient_tolerance = 1e-14;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const double* c = cameras[i].data();
    bundle.camera_from_world[i] = SE3(SO3::exp({c[0], c[1], c[2]}), {c[3], c[4], c[5]});
  }
  return summary.final_cost;
}

BundleOptions to_the_end() {
  BundleOptions options;
  options.iterations = 100;
  options.least_gain = 1e-13;
  return options;
}

TEST(BundleAdjustment, ReachesTheMinimumOfCeres) {
  const BundleSceneOptions kinds[] = {
      {.outlier_share = 0.05},                                   // one camera
      {.outlier_share = 0.05, .stereo_share = 1.0},              // two
      {.fixed = 1, .outlier_share = 0.05, .stereo_share = 0.5},  // both, with the scale from one of them only
      {.cameras = 63, .points = 250, .stereo_share = 0.3}        // enough cameras for the sparse solver
  };
  for (std::size_t kind = 0; kind < std::size(kinds); ++kind) {
    for (const bool robust : {true, false}) {
      Bundle ours = bundle_scene(kinds[kind], 3 + kind).bundle, theirs = ours;
      BundleOptions options = to_the_end();
      if (!robust) options.huber_mono = options.huber_stereo = 0.0;
      if (kind == 3 && !robust) continue;
      const BundleResult result = adjust_bundle(ours, options);
      const double cost = adjust_with_ceres(theirs, options);
      EXPECT_LT(result.last_cost, 0.7 * result.first_cost);
      EXPECT_NEAR(result.last_cost, cost, 1e-6 * cost) << kind << ' ' << robust;
      for (std::size_t i = 0; i < ours.fixed.size(); ++i)
        EXPECT_THAT(ours.camera_from_world[i], pose_near(theirs.camera_from_world[i], 1e-3, 1e-3)) << kind << ' ' << i;
    }
  }
}

TEST(BundleAdjustment, WithoutNoiseItFindsGroundTruthInFewSteps) {
  BundleScene scene = bundle_scene({.noise_sigmas = 0.0}, 1);
  BundleOptions plain = to_the_end();
  plain.huber_mono = plain.huber_stereo = 0.0;
  const BundleResult result = adjust_bundle(scene.bundle, plain);
  // Correct derivatives make the last steps quadratic.
  EXPECT_LE(result.iterations, 15);
  EXPECT_LT(result.last_cost, 1e-12 * result.first_cost);
  for (std::size_t i = 0; i < scene.points.size(); ++i)
    EXPECT_LT((scene.bundle.points[i] - scene.points[i]).norm(), 1e-5);
  for (std::size_t i = 0; i < scene.camera_from_world.size(); ++i)
    EXPECT_THAT(scene.bundle.camera_from_world[i], pose_near(scene.camera_from_world[i], 1e-6, 1e-6));
}

TEST(BundleAdjustment, OutliersAreDetectedAndHaveLittleInfluence) {
  BundleScene scene = bundle_scene({.noise_sigmas = 0.5, .outlier_share = 0.05}, 2);
  const BundleResult result = adjust_bundle(scene.bundle, {});
  int outliers = 0;
  for (std::size_t i = 0; i < scene.bundle.observations.size(); ++i) {
    const BundleObservation& seen = scene.bundle.observations[i];
    const Eigen::Vector3d p = scene.camera_from_world[seen.camera] * scene.points[seen.point];
    const bool outlier = (p.hnormalized() - seen.ray).norm() > 0.05;
    outliers += outlier;
    EXPECT_TRUE(!outlier || result.squared_errors[i] > 5.991) << i;
  }
  EXPECT_GT(outliers, 20);
  for (std::size_t i = 1; i < scene.camera_from_world.size(); ++i)
    EXPECT_LT((scene.bundle.camera_from_world[i] * scene.camera_from_world[i].inverse()).log().norm(), 0.1);
}

TEST(BundleAdjustment, PointsBehindOrUnconstrainedAreHarmless) {
  BundleScene scene = bundle_scene({}, 4);
  // A point observed by one camera only, one behind it, one without observations.
  const std::size_t open = scene.bundle.points.size();
  for (const Eigen::Vector3d& point : {Eigen::Vector3d(1, 0, 5), Eigen::Vector3d(1, 0, -5), Eigen::Vector3d(1, 2, 3)})
    scene.bundle.points.push_back(point);
  for (std::uint32_t k = 0; k < 2; ++k) {
    BundleObservation seen;
    seen.camera = 5;
    seen.point = static_cast<std::uint32_t>(open) + k;
    scene.bundle.observations.push_back(seen);
  }
  const BundleResult result = adjust_bundle(scene.bundle, {});
  EXPECT_TRUE(std::isinf(result.squared_errors.back()));
  EXPECT_EQ(scene.bundle.points.back(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(scene.bundle.points[open], Eigen::Vector3d(1, 0, 5));
  for (const SE3& pose : scene.bundle.camera_from_world) EXPECT_TRUE(pose.matrix().allFinite());
  EXPECT_LT(result.last_cost, 0.7 * result.first_cost);
}

TEST(BundleAdjustment, NothingAtAllIsDone) {
  Bundle none;
  EXPECT_TRUE(adjust_bundle(none, {}).converged);
  Bundle fixed = bundle_scene({.cameras = 3, .fixed = 3, .views = 3, .pose_off = 0.0}, 5).bundle;
  const BundleResult result = adjust_bundle(fixed, {});
  EXPECT_LT(result.last_cost, 0.5 * result.first_cost) << "points move though no camera may";
}

TEST(BundleAdjustment, SameBytesForAnyPool) {
  const BundleScene scene = bundle_scene({.cameras = 70, .points = 3000, .stereo_share = 0.5}, 6);
  Bundle alone = scene.bundle;
  adjust_bundle(alone, {});
  for (const int threads : {1, 2, 5}) {
    TaskPool pool(threads);
    Bundle other = scene.bundle;
    adjust_bundle(other, {}, &pool);
    EXPECT_EQ(std::memcmp(other.points.data(), alone.points.data(), alone.points.size() * sizeof(alone.points[0])), 0);
    for (std::size_t i = 0; i < alone.fixed.size(); ++i) {
      const Eigen::Matrix4d a = alone.camera_from_world[i].matrix(), b = other.camera_from_world[i].matrix();
      EXPECT_EQ(std::memcmp(a.data(), b.data(), sizeof(double) * 16), 0);
    }
  }
}

/// A camera that sees no point is where its relative pose says; a wrong one of another camera moves it little.
TEST(BundleAdjustment, RelativePosesHoldCamerasAndOutliersOfThemDoNot) {
  testing::BundleScene scene = testing::bundle_scene({}, 3);
  Bundle& bundle = scene.bundle;
  constexpr std::uint32_t blind = 4, other = 5;
  std::erase_if(bundle.observations, [](const BundleObservation& seen) { return seen.camera == blind; });
  const auto between = [&](std::uint32_t from, std::uint32_t to) {
    return scene.camera_from_world[to] * scene.camera_from_world[from].inverse();
  };
  const Matrix6d information = 1e6 * Matrix6d::Identity();
  bundle.relative_poses = {{blind, 3, between(blind, 3), information},
                           {other, 6, SE3(SO3(), {0.0, 0.5, 0.0}) * between(other, 6), information}};
  BundleOptions options;
  options.iterations = 30;
  const BundleResult result = adjust_bundle(bundle, options);
  EXPECT_LT(result.last_cost, result.first_cost);
  const SE3 found = bundle.camera_from_world[3] * bundle.camera_from_world[blind].inverse();
  EXPECT_LT((found * between(blind, 3).inverse()).log().norm(), 1e-6);
  EXPECT_LT((bundle.camera_from_world[other] * scene.camera_from_world[other].inverse()).log().norm(), 0.05);
}

}  // namespace
}  // namespace rastro
