// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/bundle_normal.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cstring>
#include <limits>
#include <utility>

#include "rastro/optimize/bundle_testing.h"

namespace rastro {
namespace {

using testing::bundle_scene;
using testing::BundleScene;
using testing::BundleSceneOptions;

/// Residuals of an observation in sigmas: two, or three where right_x is known.
Eigen::VectorXd errors_of(const BundleObservation& seen, const SE3& camera_from_world, const Eigen::Vector3d& point,
                          double baseline) {
  const Eigen::Vector3d p = camera_from_world * point;
  Eigen::VectorXd errors(std::isnan(seen.right_x) ? 2 : 3);
  errors.head<2>() = p.hnormalized() - seen.ray;
  if (errors.size() == 3) errors[2] = (p.x() - baseline) / p.z() - seen.right_x;
  return errors / seen.sigma;
}

/// The full normal equations, cameras before points, with numerical derivatives.
struct Dense {
  Eigen::MatrixXd normal;
  Eigen::VectorXd right;
  int cameras = 0;  ///< Free ones.
};

Dense dense_normal(const Bundle& bundle, const BundleOptions& options) {
  std::vector<int> free_index;
  Dense dense;
  for (const std::uint8_t fixed : bundle.fixed) free_index.push_back(fixed != 0 ? -1 : dense.cameras++);
  const int unknowns = 6 * dense.cameras + 3 * static_cast<int>(bundle.points.size());
  dense.normal = Eigen::MatrixXd::Zero(unknowns, unknowns);
  dense.right = Eigen::VectorXd::Zero(unknowns);
  constexpr double step = 1e-6;
  for (const BundleObservation& seen : bundle.observations) {
    const SE3& camera = bundle.camera_from_world[seen.camera];
    const Eigen::Vector3d& point = bundle.points[seen.point];
    if ((camera * point).z() < 0.01) continue;
    const Eigen::VectorXd errors = errors_of(seen, camera, point, bundle.baseline);
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(errors.size(), unknowns);
    for (int k = 0; k < 6 && free_index[seen.camera] >= 0; ++k) {
      const Vector6d d = step * Vector6d::Unit(k);
      jacobian.col(6 * free_index[seen.camera] + k) = (errors_of(seen, SE3::exp(d) * camera, point, bundle.baseline) -
                                                       errors_of(seen, SE3::exp(-d) * camera, point, bundle.baseline)) /
                                                      (2.0 * step);
    }
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d d = step * Eigen::Vector3d::Unit(k);
      jacobian.col(6 * dense.cameras + 3 * static_cast<int>(seen.point) + k) =
          (errors_of(seen, camera, point + d, bundle.baseline) - errors_of(seen, camera, point - d, bundle.baseline)) /
          (2.0 * step);
    }
    const double width = std::isnan(seen.right_x) ? options.huber_mono : options.huber_stereo, norm = errors.norm();
    const double weight = width > 0.0 && norm > width ? width / norm : 1.0;
    dense.normal += weight * jacobian.transpose() * jacobian;
    dense.right -= weight * jacobian.transpose() * errors;
  }
  for (const BundleRelativePose& measured : bundle.relative_poses) {
    const Eigen::LLT<Matrix6d> root(measured.information);
    const auto errors_at = [&](const Vector6d& by_from, const Vector6d& by_to) -> Vector6d {
      const SE3 from = SE3::exp(by_from) * bundle.camera_from_world[measured.from],
                to = SE3::exp(by_to) * bundle.camera_from_world[measured.to];
      return root.matrixU() * (to * from.inverse() * measured.to_from_from.inverse()).log();
    };
    const Vector6d errors = errors_at(Vector6d::Zero(), Vector6d::Zero()), none = Vector6d::Zero();
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(6, unknowns);
    for (int k = 0; k < 6; ++k) {
      const Vector6d d = step * Vector6d::Unit(k);
      const int from = free_index[measured.from], to = free_index[measured.to];
      if (from >= 0) jacobian.col(6 * from + k) = (errors_at(d, none) - errors_at(-d, none)) / (2.0 * step);
      if (to >= 0) jacobian.col(6 * to + k) = (errors_at(none, d) - errors_at(none, -d)) / (2.0 * step);
    }
    const double norm = errors.norm(), weight = norm > options.huber_pose ? options.huber_pose / norm : 1.0;
    dense.normal += weight * jacobian.transpose() * jacobian;
    dense.right -= weight * jacobian.transpose() * errors;
  }
  return dense;
}

BundleStep step_of(const Bundle& bundle, const BundleOptions& options, double damping, TaskPool* pool = nullptr) {
  BundleStep step;
  BundleNormal normal(bundle, options, pool);
  EXPECT_TRUE(normal.solve(bundle, damping, step));
  return step;
}

void expect_dense_step(const Bundle& bundle, const BundleOptions& options, double damping) {
  Dense dense = dense_normal(bundle, options);
  dense.normal.diagonal() *= 1.0 + damping;
  const Eigen::VectorXd expected = dense.normal.ldlt().solve(dense.right);
  const BundleStep step = step_of(bundle, options, damping);
  ASSERT_EQ(step.cameras.size(), 6 * dense.cameras);
  ASSERT_EQ(step.points.size(), bundle.points.size());
  const double size = expected.norm();
  ASSERT_GT(size, 1e-3);
  EXPECT_LT((step.cameras - expected.head(6 * dense.cameras)).norm(), 1e-4 * size) << damping;
  for (std::size_t i = 0; i < step.points.size(); ++i)
    EXPECT_LT((step.points[i] - expected.segment<3>(6 * dense.cameras + 3 * static_cast<int>(i))).norm(), 1e-4 * size)
        << i;
}

BundleSceneOptions small_scene() {
  BundleSceneOptions options;
  options.cameras = 6;
  options.points = 40;
  options.views = 4;
  return options;
}

/// Eliminating the points is exact: the step is that of the full equations.
TEST(BundleNormal, StepIsThatOfTheFullDenseEquations) {
  for (const double damping : {0.0, 1e-4, 0.1, 10.0})
    expect_dense_step(bundle_scene(small_scene(), 3).bundle, {}, damping);
}

TEST(BundleNormal, WithTwoCamerasAndWithDepthsToo) {
  BundleSceneOptions options = small_scene();
  for (const double share : {0.4, 1.0}) {
    options.stereo_share = share;
    expect_dense_step(bundle_scene(options, 5).bundle, {}, 1e-3);
  }
}

/// Between free and fixed cameras, in both orders; the last one is an outlier.
TEST(BundleNormal, RelativePosesCountAsTheirInformationSays) {
  Bundle bundle = bundle_scene(small_scene(), 3).bundle;
  bundle.fixed = {1, 0, 0, 0, 0, 1};
  Random random(5);
  const std::pair<std::uint32_t, std::uint32_t> ends[] = {{0, 2}, {3, 1}, {1, 4}, {4, 5}, {0, 5}, {2, 3}};
  for (const auto& [from, to] : ends) {
    BundleRelativePose measured{from, to, {}, Matrix6d::Identity()};
    // So small that its derivatives are those at zero.
    const double off = from == 2 ? 4e-4 : 2e-5;
    measured.to_from_from = SE3::exp(testing::random_twist(random, off)) * bundle.camera_from_world[to] *
                            bundle.camera_from_world[from].inverse();
    measured.information.diagonal() << 3e9, 1e9, 2e9, 5e9, 4e9, 3e9;
    measured.information(0, 4) = measured.information(4, 0) = 1e9;
    bundle.relative_poses.push_back(measured);
  }
  for (const double damping : {0.0, 0.1}) expect_dense_step(bundle, {}, damping);
}

TEST(BundleNormal, OutliersWeighAsTheKernelSays) {
  BundleSceneOptions options = small_scene();
  options.outlier_share = 0.2;
  options.stereo_share = 0.5;
  BundleOptions solving;
  expect_dense_step(bundle_scene(options, 7).bundle, solving, 1e-3);
  solving.huber_mono = solving.huber_stereo = 0.0;
  expect_dense_step(bundle_scene(options, 7).bundle, solving, 1e-3);
}

TEST(BundleNormal, FixedCamerasHaveNoIndexWhereverTheyAre) {
  BundleScene scene = bundle_scene(small_scene(), 9);
  scene.bundle.fixed = {0, 1, 0, 0, 1, 0};
  const BundleNormal normal(scene.bundle, {}, nullptr);
  std::vector<int> free_index;
  for (std::size_t i = 0; i < 6; ++i) free_index.push_back(normal.free_index(i));
  for (const std::size_t i : {1U, 4U}) EXPECT_LT(free_index[i], 0);
  for (const auto& [camera, index] : {std::pair<std::size_t, int>{0, 0}, {2, 1}, {3, 2}, {5, 3}})
    EXPECT_EQ(free_index[camera], index);
  expect_dense_step(scene.bundle, {}, 1e-3);
}

TEST(BundleNormal, ThePointsMoveAloneWhereEveryCameraIsFixed) {
  BundleScene scene = bundle_scene(small_scene(), 11);
  scene.bundle.fixed.assign(6, 1);
  expect_dense_step(scene.bundle, {}, 1e-6);
}

TEST(BundleNormal, PointsBehindACameraHaveNoInfluence) {
  BundleScene scene = bundle_scene(small_scene(), 13);
  scene.bundle.points[4].z() = -2.0;
  const BundleStep step = step_of(scene.bundle, {}, 0.01);
  Bundle without = scene.bundle;
  std::erase_if(without.observations, [](const BundleObservation& seen) { return seen.point == 4; });
  const BundleStep expected = step_of(without, {}, 0.01);
  EXPECT_LT((step.cameras - expected.cameras).norm(), 1e-9 * expected.cameras.norm());
}

/// Beyond 60 free cameras the matrix is sparse; beyond 128 points sums are of several chunks.
TEST(BundleNormal, ManyCamerasAndPointsAreTheSameEquations) {
  BundleSceneOptions options = small_scene();
  options.cameras = 64;
  options.points = 150;
  options.stereo_share = 0.5;
  for (const int fixed : {2, 3}) {
    options.fixed = fixed;
    BundleScene scene = bundle_scene(options, 17);
    // A loop: two cameras far from each other observe the same points.
    for (const std::uint32_t point : {0U, 3U, 7U}) {
      BundleObservation seen;
      seen.camera = 40;
      seen.point = point;
      seen.sigma = 1.0 / 500.0;
      scene.bundle.points[point] = scene.bundle.camera_from_world[40].inverse() * Eigen::Vector3d(0.1, 0.2, 4.0);
      seen.ray = Eigen::Vector2d(0.03, 0.05);
      scene.bundle.observations.push_back(seen);
    }
    expect_dense_step(scene.bundle, {}, 1e-2);
  }
}

TEST(BundleNormal, WithoutAFiniteSolutionThereIsNone) {
  BundleSceneOptions options = small_scene();
  for (const int cameras : {6, 70}) {
    options.cameras = cameras;
    options.points = 10 * cameras;
    const BundleScene scene = bundle_scene(options, 19);
    const BundleOptions solving;
    Bundle broken = scene.bundle;
    broken.observations[5].ray.x() = std::numeric_limits<double>::quiet_NaN();
    BundleNormal normal(broken, solving, nullptr);
    BundleStep step;
    EXPECT_FALSE(normal.solve(broken, 1e-3, step)) << cameras;
    EXPECT_TRUE(normal.solve(scene.bundle, 1e-3, step)) << "it recovers";
  }
}

TEST(BundleNormal, APointThatOneCameraAloneObservesStays) {
  BundleScene scene = bundle_scene(small_scene(), 21);
  std::erase_if(scene.bundle.observations, [&, kept = false](const BundleObservation& seen) mutable {
    return seen.point == 4 && std::exchange(kept, true);
  });
  const BundleStep step = step_of(scene.bundle, {}, 0.01);
  EXPECT_EQ(step.points[4].norm(), 0.0);
  EXPECT_GT(step.points[5].norm(), 0.0);
}

/// One object solves repeatedly, at other cameras and dampings.
TEST(BundleNormal, KeepsNothingFromOneSolutionToTheNext) {
  BundleScene scene = bundle_scene(small_scene(), 15);
  const BundleOptions options;
  BundleNormal normal(scene.bundle, options, nullptr);
  BundleStep first, other, again;
  ASSERT_TRUE(normal.solve(scene.bundle, 0.01, first));
  Bundle moved = scene.bundle;
  for (Eigen::Vector3d& point : moved.points) point += Eigen::Vector3d(0.05, -0.02, 0.1);
  ASSERT_TRUE(normal.solve(moved, 0.5, other));
  ASSERT_TRUE(normal.solve(scene.bundle, 0.01, again));
  EXPECT_EQ(std::memcmp(first.cameras.data(), again.cameras.data(),
                        static_cast<std::size_t>(first.cameras.size()) * sizeof(double)),
            0);
  EXPECT_GT((first.cameras - other.cameras).norm(), 1e-6);
}

}  // namespace
}  // namespace rastro
