// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/alignment_kernels.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/image/image_testing.h"
#include "rastro/math/math_testing.h"

namespace rastro {
namespace {

constexpr int wave_width = 160, wave_height = 120;

Camera small_camera() {
  Camera camera;
  camera.width = wave_width, camera.height = wave_height;
  camera.fx = 130.0, camera.fy = 125.0, camera.cx = 79.0, camera.cy = 60.5;
  return camera;
}

double wave(double x, double y) {
  return 120.0 + 35.0 * std::sin(0.16 * x + 0.05 * y) + 30.0 * std::sin(0.13 * y - 0.07 * x + 1.0);
}

/// Points at random pixels whose intensities and gradients are those of the wave, not rounded.
AlignmentPoints wave_points(int count, std::uint64_t seed) {
  Random random(seed);
  AlignmentPoints points;
  points.count = count;
  points.camera = LevelCamera(small_camera(), 0);
  const std::size_t whole = (static_cast<std::size_t>(count) + 7) / 8 * 8;
  for (auto* values : {&points.x, &points.y, &points.inverse_depth, &points.variance, &points.intensity,
                       &points.gradient_x, &points.gradient_y}) {
    values->assign(whole, std::numeric_limits<float>::quiet_NaN());
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const double x = random.uniform(2.0, wave_width - 3.0), y = random.uniform(2.0, wave_height - 3.0);
    points.x[i] = static_cast<float>((x - points.camera.cx) / points.camera.fx);
    points.y[i] = static_cast<float>((y - points.camera.cy) / points.camera.fy);
    points.inverse_depth[i] = static_cast<float>(random.uniform(0.1, 1.5));
    points.variance[i] = static_cast<float>(random.uniform(1e-6, 0.01));
    points.intensity[i] = static_cast<float>(wave(x, y)) - AlignmentPoints::mid_intensity;
    points.gradient_x[i] = static_cast<float>((wave(x + 0.01, y) - wave(x - 0.01, y)) / 0.02 * points.camera.fx);
    points.gradient_y[i] = static_cast<float>((wave(x, y + 0.01) - wave(x, y - 0.01)) / 0.02 * points.camera.fy);
  }
  return points;
}

PaddedImage wave_pixels() {
  GrayImage image(wave_width, wave_height);
  for (int y = 0; y < wave_height; ++y) {
    for (int x = 0; x < wave_width; ++x) image.at(x, y) = static_cast<std::uint8_t>(std::lround(wave(x, y)));
  }
  return testing::padded(image, alignment_padding);
}

Eigen::Vector3d point_of(const AlignmentPoints& points, std::size_t i) {
  return Eigen::Vector3d(static_cast<double>(points.x[i]), static_cast<double>(points.y[i]), 1.0) /
         static_cast<double>(points.inverse_depth[i]);
}

/// The wave where a point of the reference projects to, in double.
double intensity_at(const AlignmentPoints& points, std::size_t i, const SE3& image_from_reference) {
  const Eigen::Vector2d pixel = *small_camera().project(image_from_reference * point_of(points, i));
  return wave(pixel.x(), pixel.y());
}

TEST(AlignmentKernels, DerivativesAreThoseOfFiniteDifferences) {
  const AlignmentPoints points = wave_points(64, 1);
  const PaddedImage image = wave_pixels();
  AlignmentColumns columns;
  alignment_kernels().linearize(points, 0, 64, alignment_view(image, points.camera, SE3(), 1.0, 128.0, {}), columns);
  ASSERT_EQ(columns.used, 64);
  constexpr double step = 1e-5;
  for (std::size_t i = 0; i < 64; ++i) {
    for (int k = 0; k < 6; ++k) {
      const Vector6d d = step * Vector6d::Unit(k);
      const double expected =
          (intensity_at(points, i, SE3::exp(d)) - intensity_at(points, i, SE3::exp(-d))) / (2.0 * step);
      EXPECT_NEAR(static_cast<double>(columns.column[k][i]), expected, 1e-3 * (1.0 + std::abs(expected)) + 0.3)
          << "point " << i << " by " << k;
    }
    // Rounded pixels and bilinear interpolation of a wave with this curvature.
    EXPECT_NEAR(columns.column[8][i], 0.0, 1.2);
  }
}

/// Off the identity: geometry moves, and the gradient is the reference's rotated about the axis.
TEST(AlignmentKernels, DerivativesFollowTheMovedPoints) {
  const AlignmentPoints points = wave_points(64, 2);
  const PaddedImage image = wave_pixels();
  const SE3 pose = SE3::exp((Vector6d() << 0.05, -0.1, 0.08, 0.03, -0.05, 0.4).finished());
  const double gain = 1.3;
  AlignmentColumns columns;
  alignment_kernels().linearize(points, 0, 64, alignment_view(image, points.camera, pose, gain, 0.0, {}), columns);
  const Eigen::Matrix2d turn =
      Eigen::Rotation2Dd(std::atan2(pose.rotation().matrix()(1, 0) - pose.rotation().matrix()(0, 1),
                                    pose.rotation().matrix()(0, 0) + pose.rotation().matrix()(1, 1)))
          .toRotationMatrix();
  int compared = 0;
  for (std::size_t i = 0; i < 64; ++i) {
    if (columns.weight[i] == 0.0F) continue;
    const Eigen::Vector2d gradient = gain * turn * Eigen::Vector2d(points.gradient_x[i], points.gradient_y[i]);
    const auto moved = [&](const Vector6d& d) -> Eigen::Vector2d {
      return (pose * SE3::exp(d) * point_of(points, i)).hnormalized();
    };
    for (int k = 0; k < 6; ++k) {
      const Vector6d d = 1e-5 * Vector6d::Unit(k);
      const double expected = gradient.dot(moved(d) - moved(-d)) / 2e-5;
      EXPECT_NEAR(columns.column[k][i], expected, 1e-3 * (1.0 + std::abs(expected)));
    }
    ++compared;
  }
  EXPECT_GT(compared, 30);
}

TEST(AlignmentKernels, WeightsAreHuberOverTheVarianceWithThatOfTheDepth) {
  const AlignmentPoints points = wave_points(64, 3);
  const PaddedImage image = wave_pixels();
  const SE3 pose = SE3::exp((Vector6d() << 0.1, 0.05, -0.08, 0.01, 0.02, 0.0).finished());
  const PhotometricNoise noise;
  AlignmentColumns columns;
  AlignmentSums sums;
  alignment_kernels().linearize(points, 0, 64, alignment_view(image, points.camera, pose, 1.0, 128.0, noise), columns);
  alignment_kernels().accumulate(columns, sums);
  double cost = 0.0;
  for (std::size_t i = 0; i < 64; ++i) {
    if (columns.weight[i] == 0.0F) continue;
    AlignmentPoints moved = points;
    moved.inverse_depth[i] += 1e-3F;
    const Eigen::Vector2d step = (pose * point_of(moved, i)).hnormalized() - (pose * point_of(points, i)).hnormalized();
    const double slope = Eigen::Vector2d(points.gradient_x[i], points.gradient_y[i]).dot(step) / 1e-3;
    const double variance = 18.0 + slope * slope * static_cast<double>(points.variance[i]);
    const double residual = static_cast<double>(columns.column[8][i]);
    const double error = std::abs(residual) / std::sqrt(variance);
    EXPECT_NEAR(columns.weight[i] * variance, std::min(1.0, noise.huber_width / error), 0.02);
    cost += error < noise.huber_width ? error * error : noise.huber_width * (2.0 * error - noise.huber_width);
  }
  EXPECT_NEAR(sums.cost, cost, 0.02 * cost);
}

TEST(AlignmentKernels, SumsAreThoseOfTheColumnsInDouble) {
  const AlignmentPoints points = wave_points(203, 4);
  const PaddedImage image = wave_pixels();
  AlignmentColumns columns;
  AlignmentSums sums;
  alignment_kernels().linearize(points, 0, 203, alignment_view(image, points.camera, SE3(), 1.0, 120.0, {}), columns);
  alignment_kernels().accumulate(columns, sums);
  std::size_t at = 0;
  for (int i = 0; i < alignment_columns; ++i) {
    for (int j = i; j < alignment_columns; ++j, ++at) {
      double expected = 0.0, size = 0.0;
      for (int k = 0; k < columns.points; ++k) {
        const double product = static_cast<double>(columns.weight[k]) * static_cast<double>(columns.column[i][k]) *
                               static_cast<double>(columns.column[j][k]);
        expected += product, size += std::abs(product);
      }
      EXPECT_NEAR(sums.products[at], expected, 1e-5 * size);
    }
  }
  EXPECT_EQ(sums.inside, 203);
}

TEST(AlignmentKernels, Avx2GivesTheBytesOfThePlainVersion) {
  const PaddedImage image = wave_pixels();
  Random random(5);
  for (int trial = 0; trial < 30; ++trial) {
    const int count = 1 + static_cast<int>(random.below(alignment_chunk));
    const AlignmentPoints points = wave_points(count, 10 + static_cast<std::uint64_t>(trial));
    Vector6d tangent = testing::random_vector<Vector6d>(random, trial % 3 == 0 ? 2.0 : 0.2);
    const AlignmentView view = alignment_view(image, points.camera, SE3::exp(tangent), 1.1, 110.0, {});
    AlignmentColumns plain, fast;
    AlignmentSums of_plain, of_fast;
    alignment_kernels_plain().linearize(points, 0, count, view, plain);
    alignment_kernels_avx2().linearize(points, 0, count, view, fast);
    alignment_kernels_plain().accumulate(plain, of_plain);
    alignment_kernels_avx2().accumulate(fast, of_fast);
    const auto bytes = static_cast<std::size_t>(plain.points) * sizeof(float);
    for (int k = 0; k < alignment_columns; ++k) EXPECT_EQ(std::memcmp(plain.column[k], fast.column[k], bytes), 0) << k;
    EXPECT_EQ(std::memcmp(plain.weight, fast.weight, bytes), 0);
    EXPECT_EQ(of_plain.products, of_fast.products);
    EXPECT_EQ(of_plain.cost, of_fast.cost);
    EXPECT_EQ(of_plain.inside, of_fast.inside);
    EXPECT_EQ(of_plain.used, of_fast.used);
    EXPECT_EQ(of_plain.inliers, of_fast.inliers);
  }
}

TEST(AlignmentKernels, IgnoresPointsBehindTheCameraAndClippedOnes) {
  const AlignmentPoints points = wave_points(64, 6);
  const PaddedImage image = wave_pixels();
  AlignmentColumns columns;
  const SE3 about_face = SE3::exp((Vector6d() << 0, 0, 0, 0, 3.14, 0).finished());
  alignment_kernels().linearize(points, 0, 64, alignment_view(image, points.camera, about_face, 1.0, 0.0, {}), columns);
  EXPECT_EQ(columns.inside, 0);
  PhotometricNoise narrow;
  narrow.darkest = 120.0;
  alignment_kernels().linearize(points, 0, 64, alignment_view(image, points.camera, SE3(), 1.0, 0.0, narrow), columns);
  EXPECT_EQ(columns.inside, 64);
  EXPECT_GT(columns.used, 10);
  EXPECT_LT(columns.used, 54);
}

}  // namespace
}  // namespace rastro
