// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/similarity.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "rastro/math/math_testing.h"

namespace rastro {
namespace {

const Sim3 ground_truth(1.7, SO3::exp({0.1, -0.2, 0.15}), {0.5, -0.3, 0.4});

/// Points known to both cameras with a small error, observed with a pixel of noise.
std::vector<SimilarityPair> pairs_of(const Sim3& first_from_second, Random& random, int count, double noise,
                                     double outlier_share) {
  std::vector<SimilarityPair> pairs;
  while (static_cast<int>(pairs.size()) < count) {
    SimilarityPair pair;
    const double depth = random.uniform(3.0, 15.0), x = random.uniform(-0.6, 0.6), y = random.uniform(-0.4, 0.4);
    const Eigen::Vector3d first = depth * Eigen::Vector3d(x, y, 1.0), second = first_from_second.inverse() * first;
    if (second.z() < 0.5) continue;
    pair.first_sigma = (pairs.size() % 2 == 0 ? 1.0 : 1.44) / 500.0;
    const auto off = [&](double sigma) -> Eigen::Vector2d {
      const double dx = random.normal(), dy = random.normal();
      return noise * sigma * Eigen::Vector2d(dx, dy);
    };
    pair.first_ray = first.hnormalized() + off(pair.first_sigma);
    pair.second_ray = second.hnormalized() + off(pair.second_sigma);
    const double first_off = 1.0 + 0.01 * noise * random.normal(), second_off = 1.0 + 0.01 * noise * random.normal();
    pair.first_point = first * first_off;
    pair.second_point = second * second_off;
    if (random.uniform() < outlier_share)
      pair.second_point += testing::random_vector<Eigen::Vector3d>(random, 4.0) + Eigen::Vector3d(0, 5, 0);
    pairs.push_back(pair);
  }
  return pairs;
}

double off(const Sim3& estimate, const Sim3& expected) { return (expected.inverse() * estimate).log().norm(); }

TEST(EstimateSimilarity, IsExactWithoutNoise) {
  Random random(1);
  const auto pairs = pairs_of(ground_truth, random, 20, 0.0, 0.0);
  const auto fit = estimate_similarity(pairs, {});
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->inliers, 20);
  EXPECT_LT(off(fit->first_from_second, ground_truth), 1e-8);
}

TEST(EstimateSimilarity, IsRobustToNoiseAndHalfOutliersWithAndWithoutScale) {
  for (const bool fix_scale : {false, true}) {
    const Sim3 expected(fix_scale ? 1.0 : ground_truth.scale(), ground_truth.rotation(), ground_truth.translation());
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      Random random(seed);
      const auto pairs = pairs_of(expected, random, 100, 1.0, 0.5);
      SimilarityOptions options;
      options.fix_scale = fix_scale;
      const auto fit = estimate_similarity(pairs, options);
      ASSERT_TRUE(fit);
      EXPECT_GT(fit->inliers, 35);
      EXPECT_LT(fit->inliers, 65);
      EXPECT_LT(off(fit->first_from_second, expected), 0.03) << seed;
      EXPECT_TRUE(!fix_scale || fit->first_from_second.scale() == 1.0);
    }
  }
}

TEST(RefineSimilarity, NoStepFromTheResultFitsBetter) {
  Random random(3);
  const auto pairs = pairs_of(ground_truth, random, 60, 0.5, 0.0);
  SimilarityOptions options;
  options.chi2 = 1e6;
  options.refine_iterations = 50;
  const auto cost = [&](const Sim3& first_from_second) {
    double sum = 0.0;
    for (const SimilarityPair& pair : pairs) {
      const Eigen::Vector3d first = first_from_second * pair.second_point;
      const Eigen::Vector3d second = first_from_second.inverse() * pair.first_point;
      sum += (first.hnormalized() - pair.first_ray).squaredNorm() / std::pow(pair.first_sigma, 2);
      const double depths = std::log(pair.first_point.z() / first.z());
      sum += depths * depths / (options.depth_sigma * options.depth_sigma);
      sum += (second.hnormalized() - pair.second_ray).squaredNorm() / std::pow(pair.second_sigma, 2);
    }
    return sum;
  };
  const auto fit = refine_similarity(pairs, ground_truth * Sim3::exp(Vector7d::Constant(0.03)), options);
  ASSERT_TRUE(fit);
  const double best = cost(fit->first_from_second);
  for (int axis = 0; axis < 14; ++axis) {
    Vector7d step = Vector7d::Zero();
    step[axis / 2] = axis % 2 == 0 ? 1e-4 : -1e-4;
    EXPECT_GT(cost(Sim3::exp(step) * fit->first_from_second), best) << axis;
  }
}

TEST(EstimateSimilarity, FindsTheScaleWithBothCamerasAtOnePosition) {
  Random random(6);
  const Sim3 same_position(1.7, SO3::exp({0.02, -0.05, 0.1}), {0.001, 0.0, 0.0});
  const auto fit = estimate_similarity(pairs_of(same_position, random, 100, 1.0, 0.2), {});
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->first_from_second.scale(), 1.7, 0.05);
}

TEST(EstimateSimilarity, GivesNothingWithoutASimilarity) {
  Random random(4);
  const auto pairs = pairs_of(ground_truth, random, 20, 0.0, 0.0);
  EXPECT_FALSE(estimate_similarity({}, {}));
  EXPECT_FALSE(estimate_similarity(std::span(pairs).first(2), {}));
  EXPECT_FALSE(estimate_similarity(std::vector<SimilarityPair>(20, pairs[0]), {}));
  auto senseless = pairs;
  for (SimilarityPair& pair : senseless) pair.first_point.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(estimate_similarity(senseless, {}));
  auto unlike = pairs_of(ground_truth, random, 60, 1.0, 1.0);
  const auto fit = estimate_similarity(unlike, {});
  EXPECT_TRUE(!fit || fit->inliers < 15);
}

TEST(EstimateSimilarity, SameSeedSameBits) {
  Random random(5);
  const auto pairs = pairs_of(ground_truth, random, 100, 1.0, 0.4);
  const auto first = estimate_similarity(pairs, {}), second = estimate_similarity(pairs, {});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->first_from_second.matrix(), second->first_from_second.matrix());
}

}  // namespace
}  // namespace rastro
