// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/feature_noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/random.h"

namespace rastro {
namespace {

constexpr double set_sigma = 0.001;  ///< By the settings, normalized.

/// Points before a camera at the world's origin, seen with errors of `sigma`; of every `wrong`-th they are large.
std::vector<PointMeasurement> points_seen(double sigma, double assumed_sigma, std::uint64_t seed, int wrong = 0) {
  Random random(seed);
  std::vector<PointMeasurement> points;
  for (int i = 0; i < 300; ++i) {
    const double z = random.uniform(1.0, 4.0);
    PointMeasurement point;
    point.in_world = {z * random.uniform(-0.5, 0.5), z * random.uniform(-0.4, 0.4), z};
    const double error = wrong > 0 && i % wrong == 0 ? 0.1 : sigma;
    point.ray = point.in_world.hnormalized() + error * Eigen::Vector2d(random.normal(), random.normal());
    point.ray_sigma = assumed_sigma;
    points.push_back(point);
  }
  return points;
}

/// After so many frames in which features are off by `sigma`.
double learned(double sigma, int frames, int wrong = 0) {
  FeatureNoise noise;
  for (int k = 0; k < frames; ++k) {
    const auto points =
        points_seen(sigma, noise.factor() * set_sigma, seed_for(1, static_cast<std::uint64_t>(k)), wrong);
    noise.learn(variance_ratio(points, SE3()));
  }
  return noise.factor();
}

TEST(VarianceRatio, IsOneWhereErrorsAreAsAssumed) {
  EXPECT_NEAR(variance_ratio(points_seen(set_sigma, set_sigma, 1), SE3()), 1.0, 0.2);
  EXPECT_NEAR(variance_ratio(points_seen(2.0 * set_sigma, set_sigma, 1), SE3()), 4.0, 0.8);
  EXPECT_NEAR(variance_ratio(points_seen(2.0 * set_sigma, set_sigma, 1), SE3(), 2.0 * set_sigma), 1.0, 0.2);
  const SE3 aside(SO3(), {0.5, 0.0, 0.0});
  EXPECT_GT(variance_ratio(points_seen(set_sigma, set_sigma, 1), aside), 1e3);
}

TEST(FeatureNoise, IsThatOfTheRecording) {
  for (const double factor : {1.5, 2.0, 3.0}) EXPECT_NEAR(learned(factor * set_sigma, 40), factor, 0.1 * factor);
  // A quarter of the features moves: the median is the two thirds quantile of the others.
  EXPECT_NEAR(learned(2.0 * set_sigma, 40, 4), 2.0 * std::sqrt(2.197 / 1.386), 0.15);
}

TEST(FeatureNoise, IsThatOfTheSettingsUntilFramesTellAndNeverLess) {
  EXPECT_EQ(learned(3.0 * set_sigma, 4), 1.0);
  EXPECT_GT(learned(3.0 * set_sigma, 5), 2.0);
  EXPECT_EQ(learned(0.3 * set_sigma, 40), 1.0);
}

TEST(FeatureNoise, SurvivesPosesThatSeeNothing) {
  const SE3 beyond(SO3(), {0.0, 0.0, 10.0});
  EXPECT_EQ(variance_ratio(points_seen(set_sigma, set_sigma, 1), beyond), 1.0);
  FeatureNoise noise;
  for (int k = 0; k < 10; ++k) noise.learn(std::nan(""));
  EXPECT_EQ(noise.factor(), 1.0);
}

TEST(FeatureNoise, IsBounded) { EXPECT_EQ(learned(100.0 * set_sigma, 40), 4.0); }

TEST(FeatureNoise, ForgetsWhatWasLongAgo) {
  FeatureNoise noise;
  for (int k = 0; k < 100; ++k)
    noise.learn(k < 50 ? 9.0 / (noise.factor() * noise.factor()) : 1.0 / (noise.factor() * noise.factor()));
  EXPECT_EQ(noise.factor(), 1.0);
}

}  // namespace
}  // namespace rastro
