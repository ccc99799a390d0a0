// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/alignment_reference.h"

#include <gtest/gtest.h>

#include "rastro/image/image_testing.h"

namespace rastro {
namespace {

Camera wave_camera() {
  Camera camera;
  camera.width = 160, camera.height = 120;
  camera.fx = camera.fy = 150.0, camera.cx = 79.5, camera.cy = 59.5;
  return camera;
}

/// Inverse depth of a slanted plane, known everywhere.
double slanted_plane(double x, double y) { return 0.3 + 0.001 * x - 0.0005 * y; }

InverseDepthMap plane_map() {
  InverseDepthMap map(160, 120);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      map.mean.at(x, y) = static_cast<float>(slanted_plane(x, y));
      map.variance.at(x, y) = 1e-4F;
    }
  }
  return map;
}

TEST(InverseDepthPyramid, KeepsAPlaneAndItsVariance) {
  const auto pyramid = inverse_depth_pyramid(plane_map(), 4);
  for (int level = 0; level < 4; ++level) {
    const InverseDepthMap& map = pyramid[static_cast<std::size_t>(level)];
    const int step = 1 << level;
    for (int y = 1; y < map.height() - 1; ++y) {
      for (int x = 1; x < map.width() - 1; ++x) {
        ASSERT_NEAR(map.mean.at(x, y), slanted_plane(x * step, y * step), 1e-4) << level;
        ASSERT_NEAR(map.variance.at(x, y), 1e-4, 1e-5);
      }
    }
  }
}

TEST(InverseDepthPyramid, WeighsByVarianceAndSkipsTheUnknown) {
  InverseDepthMap fine(4, 4);
  fine.mean.at(2, 2) = 1.0F, fine.variance.at(2, 2) = 0.01F;
  fine.mean.at(3, 2) = 2.0F, fine.variance.at(3, 2) = 0.02F;
  const InverseDepthMap coarse = halve(fine);
  EXPECT_FALSE(coarse.is_known(0, 0));
  // Weights 4 and 2, divided by the variances: 400 and 100.
  EXPECT_NEAR(coarse.mean.at(1, 1), (400.0 * 1.0 + 100.0 * 2.0) / 500.0, 1e-6);
  // The spread is 0.16, the variance of the weighted mean of correlated ones 6 / 500.
  EXPECT_NEAR(coarse.variance.at(1, 1), 0.16, 1e-5);
}

TEST(AlignmentReference, PointsCarryTheRayIntensityAndGradientOfTheirPixel) {
  const GrayImage image = testing::wave_image(160, 120, 0.0, 0.0);
  AlignmentReference reference;
  reference.build(alignment_pyramid(image, 3), plane_map(), wave_camera());
  ASSERT_EQ(reference.levels(), 3);
  const AlignmentPoints& points = reference.level(0);
  EXPECT_EQ(points.x.size() % 8, 0U);
  for (std::size_t i = 0; i < static_cast<std::size_t>(points.count); ++i) {
    const int x = static_cast<int>(std::lround(points.x[i] * 150.0 + 79.5));
    const int y = static_cast<int>(std::lround(points.y[i] * 150.0 + 59.5));
    ASSERT_EQ(points.intensity[i], static_cast<float>(image.at(x, y)) - 128.0F);
    ASSERT_NEAR(points.gradient_x[i], 75.0 * (image.at(x + 1, y) - image.at(x - 1, y)), 1e-2);
    ASSERT_NEAR(points.gradient_y[i], 75.0 * (image.at(x, y + 1) - image.at(x, y - 1)), 1e-2);
    ASSERT_NEAR(points.inverse_depth[i], slanted_plane(x, y), 1e-6);
  }
  for (std::size_t i = static_cast<std::size_t>(points.count); i < points.x.size(); ++i)
    EXPECT_TRUE(std::isnan(points.x[i]));
}

TEST(AlignmentReference, KeepsTheStrongestOfEveryTileWhenThereAreTooMany) {
  const Pyramid image = alignment_pyramid(testing::wave_image(160, 120, 0.0, 0.0), 1);
  AlignmentReference all, some;
  all.build(image, plane_map(), wave_camera(), {1, 3.0, 0});
  some.build(image, plane_map(), wave_camera(), {1, 3.0, 2000});
  EXPECT_GT(all.level(0).count, 8000);
  EXPECT_EQ(some.level(0).count, 2000);
  const auto mean_square = [](const AlignmentPoints& points) {
    double sum = 0.0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(points.count); ++i)
      sum += std::pow(points.gradient_x[i], 2) + std::pow(points.gradient_y[i], 2);
    return sum / points.count;
  };
  EXPECT_GT(mean_square(some.level(0)), 1.5 * mean_square(all.level(0)));
  // Each quarter of the image keeps about a quarter of what it had.
  const auto left = [](const AlignmentPoints& points) {
    return static_cast<double>(std::count_if(points.x.begin(), points.x.end(), [](float x) { return x < 0.0F; })) /
           points.count;
  };
  EXPECT_NEAR(left(some.level(0)), left(all.level(0)), 0.03);
}

}  // namespace
}  // namespace rastro
