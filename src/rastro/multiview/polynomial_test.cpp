// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/polynomial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>

#include "rastro/base/random.h"
#include "rastro/multiview/fundamental.h"
#include "rastro/multiview/scene_testing.h"

namespace rastro {
namespace {

std::vector<double> sorted(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values;
}

/// The coefficients of a product of (x - root) and of (x - re)^2 + im^2.
Polynomial product_of(const std::vector<double>& roots, const std::vector<std::complex<double>>& pairs, double scale) {
  std::vector<double> c{scale};
  const auto times = [&](std::vector<double> factor) {
    std::vector<double> next(c.size() + factor.size() - 1, 0.0);
    for (std::size_t i = 0; i < c.size(); ++i)
      for (std::size_t j = 0; j < factor.size(); ++j) next[i + j] += c[i] * factor[j];
    c = next;
  };
  for (const double root : roots) times({-root, 1.0});
  for (const auto& pair : pairs) times({std::norm(pair), -2.0 * pair.real(), 1.0});
  Polynomial result{};
  std::copy(c.begin(), c.end(), result.begin());
  return result;
}

void expect_roots(std::vector<double> found, std::vector<double> expected, double share) {
  found = sorted(std::move(found));
  expected = sorted(std::move(expected));
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < found.size(); ++k)
    EXPECT_NEAR(found[k], expected[k], share * std::max(1.0, std::abs(expected[k]))) << k;
}

TEST(RealRoots, AreTheRootsThatThePolynomialWasMadeFrom) {
  expect_roots(real_roots(product_of({-0.5, 0.25, 0.75}, {}, 1.0)), {-0.5, 0.25, 0.75}, 1e-12);
  expect_roots(real_roots(product_of({-7.0, 0.1, 3.0, 12.0}, {}, -4.0)), {-7.0, 0.1, 3.0, 12.0}, 1e-10);
  expect_roots(real_roots(product_of({2.0}, {{0.3, 0.4}, {-1.0, 2.0}}, 0.01)), {2.0}, 1e-11);
  expect_roots(real_roots(product_of({-0.9, -0.6, -0.3, -0.1, 0.2, 0.45, 0.7, 0.95, 1.6, -2.5}, {}, 1.0)),
               {-0.9, -0.6, -0.3, -0.1, 0.2, 0.45, 0.7, 0.95, 1.6, -2.5}, 1e-8);
  EXPECT_TRUE(real_roots(product_of({}, {{0.1, 0.5}, {2.0, 0.5}, {-3.0, 1.0}}, 2.0)).empty());
}

TEST(RealRoots, OfLowDegreesAndOfNothing) {
  expect_roots(real_roots({-6.0, 3.0}), {2.0}, 1e-12);
  expect_roots(real_roots({-0.5, 1.0}), {0.5}, 1e-12);
  EXPECT_TRUE(real_roots({5.0}).empty());
  EXPECT_TRUE(real_roots({}).empty());
}

/// Against the eigenvalues of the companion matrix.
TEST(RealRoots, AreTheRealEigenvaluesOfTheCompanionMatrix) {
  Random random(5);
  int compared = 0;
  for (int trial = 0; trial < 200; ++trial) {
    Polynomial c;
    for (double& value : c) value = random.normal();
    Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(10, 10);
    companion.bottomLeftCorner(9, 9).setIdentity();
    for (int i = 0; i < 10; ++i) companion(i, 9) = -c[static_cast<std::size_t>(i)] / c[10];
    std::vector<double> expected;
    double nearly_real = 1.0;
    for (const std::complex<double>& value : companion.eigenvalues()) {
      if (std::abs(value.imag()) < 1e-9) expected.push_back(value.real());
      if (value.imag() > 1e-9) nearly_real = std::min(nearly_real, value.imag());
    }
    if (nearly_real < 1e-3) continue;  // a pair about to become real may be either
    expect_roots(real_roots(c), expected, 1e-6);
    ++compared;
  }
  EXPECT_GT(compared, 180);
}

TEST(CubicRoots, AreTheRootsThatTheCubicWasMadeFrom) {
  Random random(6);
  for (int trial = 0; trial < 500; ++trial) {
    const double a = random.uniform(-3.0, 3.0), b = random.uniform(-3.0, 3.0), c = random.uniform(-3.0, 3.0);
    if (std::min({std::abs(a - b), std::abs(b - c), std::abs(a - c)}) < 0.05) continue;
    const double scale = random.uniform(0.5, 2.0) * (trial % 2 == 0 ? 1.0 : -1.0);
    const Polynomial three = product_of({a, b, c}, {}, scale);
    expect_roots(cubic_roots(three[3], three[2], three[1], three[0]), {a, b, c}, 1e-7);
    const Polynomial one = product_of({a}, {{b, 0.2 + std::abs(c)}}, scale);
    expect_roots(cubic_roots(one[3], one[2], one[1], one[0]), {a}, 1e-9);
  }
}

TEST(CubicRoots, HandleQuadraticLinearAndConstantPolynomials) {
  expect_roots(cubic_roots(0.0, 2.0, -2.0, -12.0), {-2.0, 3.0}, 1e-12);
  EXPECT_TRUE(cubic_roots(0.0, 1.0, 0.0, 1.0).empty());
  expect_roots(cubic_roots(0.0, 0.0, 4.0, -2.0), {0.5}, 1e-12);
  EXPECT_TRUE(cubic_roots(0.0, 0.0, 0.0, 3.0).empty());
  expect_roots(cubic_roots(1.0, 0.0, 0.0, -8.0), {2.0}, 1e-12);
  for (const double root : cubic_roots(1.0, -6.0, 12.0, -8.0)) EXPECT_NEAR(root, 2.0, 1e-4) << "a triple root";
}

/// The distance is that to the nearest pair of pixels that fulfills the constraint, to first order.
TEST(SampsonDistance, IsTheDistanceToTheEpipolarConstraint) {
  Random random(7);
  const SE3 motion = testing::some_motion();
  const Eigen::Vector3d t = motion.translation();
  Eigen::Matrix3d cross;
  cross << 0.0, -t.z(), t.y(), t.z(), 0.0, -t.x(), -t.y(), t.x(), 0.0;
  const Eigen::Matrix3d fundamental = cross * motion.rotation().matrix();
  const auto scene = testing::two_view_scene(random, motion, {.count = 50});
  for (std::size_t i = 0; i < scene.a.size(); ++i) {
    EXPECT_NEAR(sampson_distance_squared(fundamental, scene.a[i], scene.b[i]), 0.0, 1e-20);
    const Eigen::Vector2d a = scene.a[i] + Eigen::Vector2d(1e-4 * random.normal(), 1e-4 * random.normal());
    const Eigen::Vector2d b = scene.b[i] + Eigen::Vector2d(1e-4 * random.normal(), 1e-4 * random.normal());
    // The nearest point of the surface b' F a = 0 by Newton steps along its gradient, both pixels free.
    Eigen::Vector4d x(a.x(), a.y(), b.x(), b.y());
    const Eigen::Vector4d start = x;
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector3d ha(x[0], x[1], 1.0), hb(x[2], x[3], 1.0);
      Eigen::Vector4d gradient;
      gradient << (fundamental.transpose() * hb).head<2>(), (fundamental * ha).head<2>();
      const double value = hb.dot(fundamental * ha) + gradient.dot(start - x);
      x = start - value / gradient.squaredNorm() * gradient;
    }
    const double exact = (x - start).squaredNorm();
    EXPECT_NEAR(sampson_distance_squared(fundamental, a, b), exact, 0.01 * exact + 1e-16) << i;
    EXPECT_NEAR(sampson_distance_squared(3.0 * fundamental, a, b), sampson_distance_squared(fundamental, a, b), 1e-16);
    EXPECT_NEAR(sampson_distance_squared(fundamental.transpose(), b, a), sampson_distance_squared(fundamental, a, b),
                1e-16);
  }
}

}  // namespace
}  // namespace rastro
