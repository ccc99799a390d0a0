// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "rastro/base/random.h"
#include "rastro/multiview/fundamental.h"
#include "rastro/multiview/homography.h"

namespace rastro {
namespace {

Eigen::Vector2d random_pixel(Random& random) { return {random.uniform(0, 752), random.uniform(0, 480)}; }

Eigen::Matrix3d some_homography() {
  Eigen::Matrix3d h;
  h << 0.95, -0.08, 20.0, 0.06, 1.03, -11.0, 5e-5, -3e-5, 1.0;
  return h;
}

/// Matches of a scene of points at 2 to 12 m observed by two cameras of focal length 450 px, with pixel noise and
/// outliers.
PointPairs two_views(Random& random, int count, double outlier_share, double noise, std::vector<bool>& is_outlier) {
  const Eigen::AngleAxisd rotation(0.05, Eigen::Vector3d(0.2, 1.0, 0.1).normalized());
  const Eigen::Vector3d shift(0.4, -0.1, 0.2);
  const auto project = [](const Eigen::Vector3d& p) {
    return Eigen::Vector2d(450.0 * p.x() / p.z() + 376.0, 450.0 * p.y() / p.z() + 240.0);
  };
  PointPairs pairs;
  for (int i = 0; i < count; ++i) {
    const double depth = random.uniform(2.0, 12.0);
    const Eigen::Vector2d pixel = random_pixel(random);
    const Eigen::Vector3d point((pixel.x() - 376.0) / 450.0 * depth, (pixel.y() - 240.0) / 450.0 * depth, depth);
    Eigen::Vector2d other = project(rotation * point + shift);
    is_outlier.push_back(random.uniform() < outlier_share);
    if (is_outlier.back()) other = random_pixel(random);
    other += noise * Eigen::Vector2d(random.normal(), random.normal());
    pairs.add(pixel.cast<float>(), other.cast<float>());
  }
  return pairs;
}

TEST(Homography, FourPairsGiveItExactly) {
  Random random(2);
  const Eigen::Matrix3d ground_truth = some_homography();
  PointPairs pairs;
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(10, 20), {700, 60}, {640, 400}, {50, 450}}) {
    pairs.add(p.cast<float>(), transfer(ground_truth, p)->cast<float>());
  }
  const std::uint32_t indices[4] = {0, 1, 2, 3};
  const auto h = homography_from_four(pairs, indices);
  ASSERT_TRUE(h);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d p = random_pixel(random);
    EXPECT_NEAR((*transfer(*h, p) - *transfer(ground_truth, p)).norm(), 0.0, 1e-3);
  }
}

TEST(Homography, ThreePointsOnALineGiveNone) {
  PointPairs pairs;
  for (const Eigen::Vector2f& p : {Eigen::Vector2f(0, 0), {10, 10}, {20, 20}, {50, 10}}) pairs.add(p, p);
  const std::uint32_t indices[4] = {0, 1, 2, 3};
  EXPECT_FALSE(homography_from_four(pairs, indices));
}

TEST(Homography, RansacFindsItAmongHalfOutliers) {
  Random random(3);
  const Eigen::Matrix3d ground_truth = some_homography();
  PointPairs pairs;
  for (int i = 0; i < 120; ++i) {
    const Eigen::Vector2d p = random_pixel(random);
    Eigen::Vector2d q = i % 2 == 0 ? *transfer(ground_truth, p) : random_pixel(random);
    q += 0.3 * Eigen::Vector2d(random.normal(), random.normal());
    pairs.add(p.cast<float>(), q.cast<float>());
  }
  const auto fit = estimate_homography(pairs, {2.0, 0.999, 1000, 5});
  ASSERT_TRUE(fit);
  EXPECT_GE(fit->inliers, 58);
  EXPECT_LE(fit->inliers, 66);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector2d p = random_pixel(random);
    EXPECT_NEAR((*transfer(fit->model, p) - *transfer(ground_truth, p)).norm(), 0.0, 0.8);
  }
}

TEST(Homography, TooFewPairsOrNansGiveNoModel) {
  PointPairs pairs;
  EXPECT_FALSE(estimate_homography(pairs, {}));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < 8; ++i) pairs.add({nan, nan}, {nan, 1.0F});
  EXPECT_FALSE(estimate_homography(pairs, {}));
}

TEST(Fundamental, SevenPairsFulfilTheConstraint) {
  Random random(4);
  std::vector<bool> is_outlier;
  const PointPairs pairs = two_views(random, 7, 0.0, 0.0, is_outlier);
  const std::uint32_t indices[7] = {0, 1, 2, 3, 4, 5, 6};
  const auto models = fundamental_from_seven(pairs, indices);
  ASSERT_FALSE(models.empty());
  for (const auto& f : models) {
    for (std::size_t i = 0; i < 7; ++i) EXPECT_LT(sampson_distance_squared(f, pairs.a(i), pairs.b(i)), 1e-6);
    EXPECT_NEAR(f.determinant() / std::pow(f.norm(), 3), 0.0, 1e-9);
  }
}

TEST(Fundamental, RansacRejectsOutliers) {
  Random random(8);
  std::vector<bool> is_outlier;
  const PointPairs pairs = two_views(random, 150, 0.2, 0.2, is_outlier);
  const auto fit = estimate_fundamental(pairs, {1.0, 0.99, 500, 7});
  ASSERT_TRUE(fit);
  int kept_true = 0, kept_false = 0, truths = 0, outliers = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const bool kept = fit->squared_errors[i] <= 1.0F;
    (is_outlier[i] ? outliers : truths) += 1;
    if (kept) (is_outlier[i] ? kept_false : kept_true) += 1;
  }
  EXPECT_GE(kept_true, truths * 97 / 100);
  // Some outliers fall near their epipolar line by chance.
  EXPECT_LE(kept_false, outliers / 5);
}

TEST(Ransac, SameSeedSameModel) {
  Random random(9);
  std::vector<bool> is_outlier;
  const PointPairs pairs = two_views(random, 100, 0.3, 0.3, is_outlier);
  const auto a = estimate_fundamental(pairs, {1.0, 0.99, 500, 7}), b = estimate_fundamental(pairs, {1.0, 0.99, 500, 7});
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->model, b->model);
  EXPECT_EQ(a->squared_errors, b->squared_errors);
}

}  // namespace
}  // namespace rastro
