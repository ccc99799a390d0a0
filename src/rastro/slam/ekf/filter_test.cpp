// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/filter.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/math/math_testing.h"

namespace rastro {
namespace {

using testing::matrix_near;
using testing::random_vector;

const Eigen::Matrix3d motion_noise = Eigen::Vector3d(4e-4, 1e-4, 9e-4).asDiagonal();
const Eigen::Matrix2d sensor_noise = (Eigen::Matrix2d() << 0.01, 0.002, 0.002, 0.02).finished();

const Eigen::Vector2d scale_sigma(0.02, 0.04);

SE2 motion(double x, double y, double angle) { return {SO2::from_angle(angle), {x, y}}; }

/// The textbook filter: full matrices, every product written out. State: x, y, angle, the odometry's scale in
/// translation and rotation, then landmarks.
struct DenseFilter {
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(5);
  Eigen::MatrixXd covariance = prior();

  static Eigen::MatrixXd prior() {
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(5, 5);
    covariance.diagonal().tail<2>() = scale_sigma.cwiseAbs2();
    return covariance;
  }
  static Eigen::VectorXd moved(Eigen::VectorXd state, const Eigen::Vector3d& step) {
    const Eigen::Vector2d told = step.head<2>();
    state.head<2>() += (1.0 + state[3]) * (SO2::from_angle(state[2]) * told);
    state[2] += (1.0 + state[4]) * step.z();
    return state;
  }
  static Eigen::Vector2d seen(const Eigen::VectorXd& state, Eigen::Index landmark) {
    return SE2(SO2::from_angle(state[2]), state.head<2>()).inverse() * state.segment<2>(5 + 2 * landmark).eval();
  }
  static Eigen::VectorXd with_landmark(const Eigen::VectorXd& state, const Eigen::Vector2d& in_body) {
    Eigen::VectorXd result(state.size() + 2);
    result << state, SE2(SO2::from_angle(state[2]), state.head<2>()) * in_body;
    return result;
  }
  /// By central differences, accurate to about 1e-10.
  template <typename Function>
  static Eigen::MatrixXd derivative(const Function& function, const Eigen::VectorXd& at) {
    const double step = 1e-5;
    Eigen::MatrixXd result(function(at).size(), at.size());
    for (Eigen::Index i = 0; i < at.size(); ++i) {
      Eigen::VectorXd high = at, low = at;
      high[i] += step;
      low[i] -= step;
      result.col(i) = (function(high) - function(low)) / (2.0 * step);
    }
    return result;
  }

  void predict(const Eigen::Vector3d& step, const Eigen::Matrix3d& noise) {
    const Eigen::MatrixXd F = derivative([&](const Eigen::VectorXd& x) { return moved(x, step); }, mean);
    // The noise is that of the motion as it was, not of what is told.
    Eigen::VectorXd unscaled = mean;
    unscaled.segment<2>(3).setZero();
    const Eigen::MatrixXd G = derivative([&](const Eigen::VectorXd& u) { return moved(unscaled, u); }, step);
    covariance = F * covariance * F.transpose() + G * noise * G.transpose();
    mean = moved(mean, step);
  }
  void update(Eigen::Index landmark, const Eigen::Vector2d& in_body, const Eigen::Matrix2d& noise) {
    const auto [A, K] = corrected(landmark, in_body, noise);
    covariance = A * covariance * A.transpose() + K * noise * K.transpose();
  }
  void update_in_short_form(Eigen::Index landmark, const Eigen::Vector2d& in_body, const Eigen::Matrix2d& noise) {
    const Eigen::MatrixXd A = corrected(landmark, in_body, noise).first;
    covariance = (A * covariance).eval();
    covariance = (0.5 * (covariance + covariance.transpose())).eval();
  }
  /// Corrects the mean; returns I - KH and K.
  std::pair<Eigen::MatrixXd, Eigen::MatrixXd> corrected(Eigen::Index landmark, const Eigen::Vector2d& in_body,
                                                        const Eigen::Matrix2d& noise) {
    const auto measure = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd { return seen(x, landmark); };
    const Eigen::MatrixXd H = derivative(measure, mean);
    const Eigen::MatrixXd K = covariance * H.transpose() * (H * covariance * H.transpose() + noise).inverse();
    mean += K * (in_body - seen(mean, landmark));
    return {Eigen::MatrixXd::Identity(mean.size(), mean.size()) - K * H, K};
  }
  void add(const Eigen::Vector2d& in_body, const Eigen::Matrix2d& noise) {
    const auto by_state = [&](const Eigen::VectorXd& x) { return with_landmark(x, in_body); };
    const auto by_sight = [&](const Eigen::VectorXd& z) { return with_landmark(mean, z); };
    const Eigen::MatrixXd J = derivative(by_state, mean), N = derivative(by_sight, in_body);
    covariance = J * covariance * J.transpose() + N * noise * N.transpose();
    mean = with_landmark(mean, in_body);
  }
};

Eigen::VectorXd mean_of(const EkfFilter& filter) {
  Eigen::VectorXd mean(5 + 2 * static_cast<Eigen::Index>(filter.landmarks()));
  mean.head<2>() = filter.world_from_body().translation();
  mean[2] = filter.world_from_body().rotation().angle();
  mean.segment<2>(3) = filter.odometry_scale();
  for (std::size_t i = 0; i < filter.landmarks(); ++i) {
    mean.segment<2>(5 + 2 * static_cast<Eigen::Index>(i)) = filter.landmark(i);
  }
  return mean;
}

double least_eigenvalue(const Eigen::MatrixXd& matrix) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix).eigenvalues().minCoeff();
}

TEST(EkfFilter, EqualsTheTextbookWithFullMatricesAndNumericDerivatives) {
  Random random(3);
  EkfFilter filter({}, scale_sigma);
  DenseFilter dense;
  for (int step = 0; step < 60; ++step) {
    const Eigen::Vector3d moved(0.3, 0.02, 0.1);
    filter.predict(motion(moved.x(), moved.y(), moved.z()), motion_noise);
    dense.predict(moved, motion_noise);
    if (step % 2 == 0) {  // 30 landmarks: the memory of the filter has to grow once
      const Eigen::Vector2d in_body = random_vector<Eigen::Vector2d>(random, 5.0);
      filter.add(in_body, sensor_noise);
      dense.add(in_body, sensor_noise);
    }
    const std::size_t seen = random.below(static_cast<std::uint32_t>(filter.landmarks()));
    const Eigen::Vector2d in_body = filter.expected(seen).in_body + random_vector<Eigen::Vector2d>(random, 0.1);
    filter.update(seen, in_body, sensor_noise);
    dense.update(static_cast<Eigen::Index>(seen), in_body, sensor_noise);
  }
  dense.mean[2] = std::remainder(dense.mean[2], 2.0 * std::numbers::pi);
  EXPECT_THAT(mean_of(filter), matrix_near(dense.mean, 1e-8));
  EXPECT_THAT(filter.covariance(), matrix_near(dense.covariance, 1e-8));
  EXPECT_GT(least_eigenvalue(filter.covariance()), 0.0);
}

TEST(EkfFilter, PredictsTheObservationWithTheCovarianceOfTheDifference) {
  EkfFilter filter;
  filter.predict(motion(1.0, 0.0, 0.5), motion_noise);
  filter.add({2.0, 1.0}, sensor_noise);
  // Both were observed at the same instant, so the body's own error cancels.
  EXPECT_THAT(filter.expected(0).in_body, matrix_near(Eigen::Vector2d(2.0, 1.0), 1e-12));
  EXPECT_THAT(filter.expected(0).covariance, matrix_near(sensor_noise, 1e-12));
}

TEST(EkfFilter, KnowsDistancesBetterThanPositions) {
  EkfFilter filter;
  filter.predict(motion(1.0, 0.0, 0.5), 100.0 * motion_noise);
  filter.add({2.0, 1.0}, sensor_noise);
  filter.add({5.0, 5.0}, sensor_noise);
  const Eigen::Matrix2d cross = filter.landmark_covariance(0, 1);
  EXPECT_EQ(filter.landmark_covariance(1, 0), cross.transpose());
  EXPECT_EQ(filter.landmark_covariance(1, 1), filter.landmark_covariance(1));
  const Eigen::Matrix2d of_difference =
      filter.landmark_covariance(0) + filter.landmark_covariance(1) - cross - Eigen::Matrix2d(cross.transpose());
  // Along the line between them, neither the body's position nor its angle contributes: only both observations.
  const Eigen::Vector2d along = (filter.landmark(1) - filter.landmark(0)).normalized();
  const Eigen::Vector2d along_in_body(0.6, 0.8);
  EXPECT_NEAR(along.dot(of_difference * along), 2.0 * along_in_body.dot(sensor_noise * along_in_body), 1e-12);
  EXPECT_GT(filter.landmark_covariance(0).trace(), 10.0 * along.dot(of_difference * along));
}

TEST(EkfFilter, UnitesTwoLandmarksAsTheFullMatrixFormDoes) {
  EkfFilter filter({}, scale_sigma);
  filter.add({2.0, 1.0}, sensor_noise);
  filter.add({4.0, -1.0}, sensor_noise);
  for (int step = 0; step < 5; ++step) filter.predict(motion(1.0, 0.1, 0.3), 100.0 * motion_noise);
  filter.add(filter.expected(0).in_body + Eigen::Vector2d(0.2, -0.1), sensor_noise);

  const Eigen::MatrixXd P = filter.covariance();
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2, P.cols());
  H.middleCols<2>(5).setIdentity();
  H.middleCols<2>(9) = -Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d noise = 1e-4 * Eigen::Matrix2d::Identity();
  const Eigen::MatrixXd gain = P * H.transpose() * (H * P * H.transpose() + noise).inverse();
  const Eigen::VectorXd mean = mean_of(filter) - gain * (H * mean_of(filter));
  filter.unite(0, 2, noise);
  EXPECT_THAT(mean_of(filter), matrix_near(mean, 1e-9));
  EXPECT_THAT(filter.covariance(), matrix_near(P - gain * H * P, 1e-9));
  EXPECT_LT((filter.landmark(0) - filter.landmark(2)).norm(), 0.01);
  EXPECT_GT(least_eigenvalue(filter.covariance()), 0.0);
}

TEST(EkfFilter, AUselessSensorChangesNothingAndAPerfectOneFixesTheLandmark) {
  EkfFilter filter;
  filter.predict(motion(1.0, 0.0, 0.5), motion_noise);
  filter.add({2.0, 1.0}, sensor_noise);
  filter.predict(motion(1.0, 0.0, 0.5), motion_noise);
  const Eigen::MatrixXd before = filter.covariance();
  filter.update(0, {5.0, 5.0}, 1e12 * Eigen::Matrix2d::Identity());
  EXPECT_THAT(filter.covariance(), matrix_near(before, 1e-9));
  filter.update(0, filter.expected(0).in_body, 1e-12 * Eigen::Matrix2d::Identity());
  EXPECT_LT(filter.expected(0).covariance.norm(), 1e-11);
}

TEST(EkfFilter, StaysPositiveDefiniteWhereTheShortFormDoesNot) {
  // A prior of 10 m, then a sensor accurate to 0.01 mm, repeatedly: 12 digits between their variances.
  const Eigen::Matrix3d doubt = Eigen::Vector3d(100.0, 100.0, 0.01).asDiagonal();
  const Eigen::Matrix2d precise = 1e-10 * Eigen::Matrix2d::Identity();
  EkfFilter filter({}, scale_sigma);
  DenseFilter shortened;
  for (const Eigen::Vector2d& position : {Eigen::Vector2d(3.0, 1.0), Eigen::Vector2d(-2.0, 4.0)}) {
    filter.add(position, precise);
    shortened.add(position, precise);
  }
  double least = 1.0, least_shortened = 1.0;
  for (int step = 0; step < 20; ++step) {
    filter.predict(motion(0.1, 0.0, 0.05), doubt);
    shortened.predict({0.1, 0.0, 0.05}, doubt);
    for (int landmark = 0; landmark < 2; ++landmark) {
      const Eigen::Vector2d in_body = DenseFilter::seen(shortened.mean, landmark);
      filter.update(static_cast<std::size_t>(landmark), in_body, precise);
      shortened.update_in_short_form(landmark, in_body, precise);
      least = std::min(least, least_eigenvalue(filter.covariance()));
      least_shortened = std::min(least_shortened, least_eigenvalue(shortened.covariance));
    }
  }
  EXPECT_LT(least_shortened, -1e-10);
  EXPECT_GT(least, 1e-12);
}

TEST(EkfFilter, RemovesALandmarkAndKeepsTheRest) {
  for (const std::size_t forgotten : {0U, 1U, 3U}) {
    EkfFilter filter;
    for (int i = 0; i < 4; ++i) {
      filter.predict(motion(0.3, 0.0, 0.2), motion_noise);
      filter.add({3.0 - i, 1.0 + i}, sensor_noise);
    }
    std::vector<Eigen::Index> kept = {0, 1, 2, 3,
                                      4};  // of the state: body and scale, then landmarks in their new order
    for (std::size_t landmark = 0; landmark < 3; ++landmark) {
      const auto row = 5 + 2 * static_cast<Eigen::Index>(landmark == forgotten ? 3 : landmark);
      kept.push_back(row);
      kept.push_back(row + 1);
    }
    const Eigen::VectorXd mean = mean_of(filter);
    const Eigen::MatrixXd covariance = filter.covariance();
    filter.remove(forgotten);
    EXPECT_EQ(mean_of(filter), mean(kept).eval());
    EXPECT_EQ(filter.covariance(), covariance(kept, kept).eval());
  }
}

TEST(EkfFilter, FindsTheOdometrysScaleFromLandmarksItKnows) {
  // Landmarks beside a long path, each observed three times; wheels that tell 2 % less and rotations that tell 4 %
  // more.
  const Eigen::Vector2d scale(0.02, -0.04);
  EkfFilter filter({}, scale_sigma);
  SE2 world_from_body;
  for (int step = 0; step < 1000; ++step) {
    const double angle = step % 20 < 10 ? 0.05 : -0.05;
    if (step % 3 == 0) filter.add({2.0, 1.0}, 1e-2 * sensor_noise);
    const Eigen::Vector2d landmark = world_from_body * Eigen::Vector2d(2.0, 1.0);
    world_from_body = world_from_body * motion(0.2 * (1.0 + scale.x()), 0.0, angle * (1.0 + scale.y()));
    filter.predict(motion(0.2, 0.0, angle), 1e-2 * motion_noise);
    if (step % 3 == 0) filter.update(filter.landmarks() - 1, world_from_body.inverse() * landmark, 1e-2 * sensor_noise);
  }
  EXPECT_THAT(filter.odometry_scale(), matrix_near(scale, 0.005));
  const Eigen::VectorXd variances = filter.covariance().diagonal();
  EXPECT_LT(variances[3], 0.1 * scale_sigma.x() * scale_sigma.x());
  EXPECT_GT(variances[3], 0.0);
}

TEST(EkfFilter, PredictionIncreasesTheCovarianceAndAnUpdateReducesIt) {
  EkfFilter filter;
  filter.add({2.0, 1.0}, sensor_noise);
  filter.predict(motion(1.0, 0.2, 0.5), motion_noise);
  const Eigen::MatrixXd predicted = filter.covariance();
  filter.update(0, filter.expected(0).in_body, sensor_noise);
  EXPECT_GE(least_eigenvalue(predicted - filter.covariance()), -1e-15);
  EXPECT_LT(filter.body_covariance().trace(), 0.99 * (predicted.topLeftCorner<3, 3>().trace()));
}

TEST(EkfFilter, TakesLittleMoreMemoryThanItsLandmarksNeed) {
  EkfFilter filter, bounded;
  bounded.expect_at_most(40);
  for (int i = 0; i < 40; ++i) {
    filter.add({3.0, 0.1 * i}, sensor_noise);
    bounded.add({3.0, 0.1 * i}, sensor_noise);
    EXPECT_GE(bounded.bytes(), EkfFilter::bytes_of(bounded.landmarks()));
  }
  EXPECT_GE(filter.bytes(), EkfFilter::bytes_of(40));
  EXPECT_LT(filter.bytes(), EkfFilter::bytes_of(40) * 8 / 5);
  EXPECT_EQ(bounded.bytes(), EkfFilter::bytes_of(40));
}

}  // namespace
}  // namespace rastro
