// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/pose_solver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "rastro/base/random.h"
#include "rastro/math/math_testing.h"

namespace rastro {
namespace {

using testing::matrix_near;
using testing::pose_near;
using testing::random_vector;

const SE3 true_pose(SO3::exp({0.2, -0.5, 0.1}), {0.4, -0.3, 1.2});
constexpr double wide = 1e6;  ///< A kernel that is quadratic everywhere.

/// Points of a map 1 to 4 m ahead with exact observations; every other one has a depth reading.
std::vector<PointMeasurement> exact_points(int count, std::uint64_t seed = 1) {
  Random random(seed);
  std::vector<PointMeasurement> points;
  for (int i = 0; i < count; ++i) {
    const double z = random.uniform(1.0, 4.0);
    const Eigen::Vector3d p(z * random.uniform(-0.5, 0.5), z * random.uniform(-0.4, 0.4), z);
    PointMeasurement point;
    point.in_world = true_pose * p;
    point.in_world_per_inverse_depth = -z * (true_pose.rotation() * p);  // first observed from about here
    point.ray = p.hnormalized();
    point.ray_sigma = 0.002;
    if (i % 2 == 0) point.inverse_depth = 1.0 / z, point.inverse_depth_sigma = 0.005;
    points.push_back(point);
  }
  return points;
}

/// Half the squared standardised residuals of all measurements, written out, with the map's uncertainty fixed at `at`.
double cost_of(const std::vector<PointMeasurement>& points, const SE3& pose, const SE3& at) {
  double cost = 0.0;
  for (const PointMeasurement& point : points) {
    const auto predicted = [&](const SE3& from, const Eigen::Vector3d& in_world) {
      const Eigen::Vector3d p = from.inverse() * in_world;
      return Eigen::Vector3d(p.x() / p.z(), p.y() / p.z(), point.inverse_depth > 0.0 ? 1.0 / p.z() : 0.0);
    };
    constexpr double step = 1e-6;
    const Eigen::Vector3d along = (predicted(at, point.in_world + step * point.in_world_per_inverse_depth) -
                                   predicted(at, point.in_world - step * point.in_world_per_inverse_depth)) /
                                  (2.0 * step);
    Eigen::Matrix3d noise = Eigen::Vector3d(point.ray_sigma * point.ray_sigma, point.ray_sigma * point.ray_sigma,
                                            point.inverse_depth_sigma * point.inverse_depth_sigma)
                                .asDiagonal();
    noise += point.inverse_depth_variance * along * along.transpose();
    const Eigen::Vector3d error =
        Eigen::Vector3d(point.ray.x(), point.ray.y(), point.inverse_depth) - predicted(pose, point.in_world);
    cost += 0.5 * error.dot(noise.inverse() * error);
  }
  return cost;
}

TEST(PointsQuadratic, GradientAndInformationAreThoseOfTheCostByDifferences) {
  auto points = exact_points(20);
  for (PointMeasurement& point : points) point.inverse_depth_variance = 1e-4;
  Random random(4);
  const SE3 pose = true_pose * SE3::exp(random_vector<Vector6d>(random, 0.01));
  const PoseQuadratic quadratic = points_quadratic(points, pose, wide);
  constexpr double step = 1e-5;
  for (int k = 0; k < 6; ++k) {
    const Vector6d d = step * Vector6d::Unit(k);
    const double downhill =
        -(cost_of(points, pose * SE3::exp(d), pose) - cost_of(points, pose * SE3::exp(-d), pose)) / (2.0 * step);
    EXPECT_NEAR(quadratic.gradient[k] / downhill, 1.0, 1e-4) << k;
  }
  // With zero residuals the Gauss-Newton matrix equals the Hessian.
  const PoseQuadratic at_ground_truth = points_quadratic(points, true_pose, wide);
  for (int a = 0; a < 6; ++a) {
    for (int b = 0; b <= a; ++b) {
      constexpr double h = 1e-4;
      const Vector6d da = h * Vector6d::Unit(a), db = h * Vector6d::Unit(b);
      const auto cost = [&](const Vector6d& d) { return cost_of(points, true_pose * SE3::exp(d), true_pose); };
      const double second = (cost(da + db) - cost(da - db) - cost(db - da) + cost(-da - db)) / (4.0 * h * h);
      EXPECT_NEAR(at_ground_truth.information(a, b), second, 2e-3 * at_ground_truth.information.diagonal().maxCoeff())
          << a << b;
    }
  }
}

TEST(PointsQuadratic, PointsBehindTheCameraAndFarOutliersHardlyCount) {
  auto points = exact_points(30);
  const PoseQuadratic before = points_quadratic(points, true_pose, 2.0);
  PointMeasurement behind = points[0];
  behind.in_world = true_pose * Eigen::Vector3d(0.1, 0.1, -2.0);
  points.push_back(behind);
  EXPECT_EQ(points_quadratic(points, true_pose, 2.0).information, before.information);
  points.back() = points[0];
  points.back().ray += Eigen::Vector2d(0.5, 0.0);  // 250 sigmas
  const PoseQuadratic with = points_quadratic(points, true_pose, 2.0);
  EXPECT_LT(with.gradient.norm(), 0.02 * points_quadratic(points, true_pose, wide).gradient.norm());
  EXPECT_THAT(with.information, matrix_near(before.information, 0.01 * before.information.norm()));
}

TEST(SolvePose, ConvergesToTheTruePoseFromAPerturbedStart) {
  Random random(9);
  for (int trial = 0; trial < 20; ++trial) {
    const SE3 start = true_pose * SE3::exp(random_vector<Vector6d>(random, 0.08));
    const PoseSolution solution = solve_pose(exact_points(40, 20 + static_cast<std::uint64_t>(trial)), 0.0, start, 20);
    EXPECT_TRUE(solution.converged);
    EXPECT_THAT(solution.world_from_camera, pose_near(true_pose, 1e-6, 1e-6));
  }
}

TEST(SolvePose, ItsErrorAgreesWithItsInformation) {
  Random random(10);
  double sum = 0.0;
  constexpr int runs = 200;
  for (int run = 0; run < runs; ++run) {
    auto points = exact_points(40, static_cast<std::uint64_t>(run));
    for (PointMeasurement& point : points) {
      point.ray.x() += point.ray_sigma * random.normal();
      point.ray.y() += point.ray_sigma * random.normal();
      if (point.inverse_depth > 0.0) point.inverse_depth += point.inverse_depth_sigma * random.normal();
    }
    const PoseSolution solution = solve_pose(points, 0.0, true_pose, 20);
    const Vector6d error = (solution.world_from_camera.inverse() * true_pose).log();
    sum += error.dot(solution.points.information * error);
  }
  // Cauchy's kernel takes about a third of the information of normal errors.
  EXPECT_GT(sum / runs, 2.5);
  EXPECT_LT(sum / runs, 8.0);
}

TEST(SolvePose, ACommonErrorIsNotAveragedOutByManyPoints) {
  constexpr double shared = 0.003;
  for (const int count : {50, 5000}) {
    const PoseSolution solution = solve_pose(exact_points(count), shared, true_pose, 5);
    const Matrix6d covariance = solution.shared_points.information.inverse();
    for (int k = 3; k < 6; ++k) EXPECT_GE(covariance(k, k), 0.999 * shared * shared) << count;
    for (int k = 0; k < 3; ++k) EXPECT_GE(covariance(k, k), shared * shared) << count << ": by depth, above 1 m";
    const Matrix6d sum = solution.points.information.inverse();
    const Matrix6d added = covariance - sum;
    EXPECT_NEAR(added(4, 4) / (shared * shared), 1.0, 1e-3) << "it is added to the uncertainty of the points";
  }
}

TEST(SolvePose, UnobservableDirectionsKeepTheirValue) {
  const SE3 start = true_pose * SE3::exp((Vector6d() << 0.05, 0.0, 0.0, 0.0, 0.02, 0.0).finished());
  EXPECT_THAT(solve_pose({}, 0.001, start, 10).world_from_camera, pose_near(start, 1e-12, 1e-12));
  // One point without depth constrains two of six directions.
  auto one = exact_points(2);
  one.erase(one.begin());
  const PoseSolution solution = solve_pose(one, 0.0, start, 20);
  const Eigen::Vector3d p = solution.world_from_camera.inverse() * one[0].in_world;
  EXPECT_LT((p.hnormalized() - one[0].ray).norm(), 1e-5) << "it projects to its observation";
  EXPECT_LT((start.inverse() * solution.world_from_camera).log().norm(), 0.06) << "and no other direction moved far";
}

/// Another source with a strong prior on one translation prevails there; the points determine the rest.
TEST(SolvePose, OthersAreWeightedWithThePoints) {
  const Eigen::Vector3d wanted = true_pose.translation() + Eigen::Vector3d(0.0, 0.0, 0.02);
  const auto others = [&](const SE3& pose, int) {
    PoseQuadratic quadratic;
    const Eigen::Vector3d off = pose.rotation().inverse() * Eigen::Vector3d(wanted - pose.translation());
    quadratic.information.topLeftCorner<3, 3>() = 1e10 * Eigen::Matrix3d::Identity();
    quadratic.gradient.head<3>() = 1e10 * off;
    return quadratic;
  };
  const PoseSolution solution = solve_pose(exact_points(40), 0.0, true_pose, 20, others);
  EXPECT_LT((solution.world_from_camera.translation() - wanted).norm(), 1e-4);
  EXPECT_THAT(solution.by_points_alone(), pose_near(true_pose, 2e-3, 2e-3)) << "their own solution";
  EXPECT_GT((solution.world_from_camera.inverse() * true_pose).log().norm(), 0.015);
}

/// Depths read later than assumed: each is wrong by its rate times the delay.
TEST(PointsWithDelay, FindTheDelayOfDepthAlongWithThePose) {
  constexpr double delay = 0.012;
  auto points = exact_points(60);
  Random random(31);
  for (PointMeasurement& point : points) {
    if (point.inverse_depth <= 0.0) continue;
    point.per_second = random.uniform(-1.0, 1.0);
    point.inverse_depth -= delay * point.per_second;
  }
  SE3 pose = true_pose;
  double found = 0.0;
  for (int k = 0; k < 15; ++k) {
    auto corrected = points;
    for (PointMeasurement& point : corrected) point.inverse_depth += found * point.per_second;
    const DelayedQuadratic quadratic = points_with_delay(corrected, pose);
    const Eigen::Matrix<double, 7, 1> step = quadratic.information.ldlt().solve(quadratic.gradient);
    pose = pose * SE3::exp(step.head<6>());
    found += step[6];
  }
  EXPECT_NEAR(found, delay, 1e-6);
  EXPECT_THAT(pose, pose_near(true_pose, 1e-6, 1e-6));
}

TEST(PointsWithDelay, InformationOnTheDelayIsTheSchurComplement) {
  auto points = exact_points(30);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].per_second = 0.2 * static_cast<double>(i % 5) - 0.3;
  const SE3 pose = true_pose * SE3::exp((Vector6d() << 0.01, 0.0, -0.01, 0.0, 0.005, 0.0).finished());
  const DelayedQuadratic quadratic = points_with_delay(points, pose);
  const auto [information, gradient] = delay_alone(quadratic);
  const Eigen::Matrix<double, 7, 7> covariance = quadratic.information.inverse();
  EXPECT_NEAR(information * covariance(6, 6), 1.0, 1e-3);
  EXPECT_NEAR(gradient / information, quadratic.information.ldlt().solve(quadratic.gradient)[6], 1e-5);
  EXPECT_THAT(Matrix6d(quadratic.information.topLeftCorner<6, 6>()),
              matrix_near(points_quadratic(points, pose, 2.0).information, 1e-6 * quadratic.information.norm()));
}

}  // namespace
}  // namespace rastro
