// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/free_area.h"

#include <gtest/gtest.h>

#include "rastro/image/image_testing.h"
#include "rastro/track/undistorted_camera.h"

namespace rastro {
namespace {

struct Disc {
  float x, y;
  double radius;
};

TEST(FreeArea, IsWhatLiesInNoDiscAndNotUnderTheMask) {
  const std::vector<Disc> discs = {{20.4F, 9.6F, 7.0},  {0.0F, 0.0F, 5.5},   {49.0F, 39.0F, 1.0}, {60.0F, 20.0F, 15.0},
                                   {25.0F, -4.0F, 6.0}, {10.0F, 30.0F, 0.5}, {40.0F, 30.0F, 0.0}, {33.0F, 20.0F, 7.0}};
  GrayImage mask = testing::noise_image(50, 40, 1);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 50; ++x) mask.at(x, y) = mask.at(x, y) < 64 ? 0 : 255;
  FreeArea area;
  for (const bool masked : {false, true, false}) {
    area.reset(50, 40, masked ? mask.view() : GrayView());
    for (const Disc& disc : discs) area.block({disc.x, disc.y}, disc.radius);
    for (int y = 0; y < 40; ++y) {
      for (int x = 0; x < 50; ++x) {
        bool free = !masked || mask.at(x, y) != 0;
        for (const Disc& disc : discs) {
          const double dx = x - std::lround(disc.x), dy = y - std::lround(disc.y);
          free = free && dx * dx + dy * dy >= disc.radius * disc.radius;
        }
        ASSERT_EQ(area.view().at(x, y) != 0, free) << x << ' ' << y;
      }
    }
  }
}

TEST(FreeArea, TakesAnotherSize) {
  FreeArea area;
  area.reset(50, 40, {});
  for (const auto& [width, height] : {std::pair{50, 60}, {70, 60}, {8, 9}}) {
    area.reset(width, height, {});
    EXPECT_EQ(area.view().width, width);
    EXPECT_EQ(area.view().height, height);
    EXPECT_EQ(area.view().at(width - 1, height - 1), 255);
  }
}

Camera distorted_camera() {
  Camera camera = camera_from_field_of_view(80.0, 640, 480);
  camera.fy = 1.1 * camera.fx, camera.cx = 300.0, camera.cy = 250.0;
  camera.distortion = Distortion::radial_tangential;
  camera.coefficients = {-0.2, 0.05, 0.001, -0.002, 0.0};
  return camera;
}

TEST(UndistortedCamera, MovesAPixelWhereACameraWithoutDistortionSeesTheSameRay) {
  const Camera camera = distorted_camera();
  Camera straight = camera;
  straight.distortion = Distortion::none;
  const UndistortedCamera ideal(camera);
  for (const Eigen::Vector3d& point : {Eigen::Vector3d(0.5, 0.3, 1.0), {-1.0, 0.4, 2.0}, {0.0, -0.6, 1.5}}) {
    const Eigen::Vector2d seen = camera.project(point).value(), expected = straight.project(point).value();
    EXPECT_GT((seen - expected).norm(), 1.0);
    const Eigen::Vector2f found = ideal.from_pixel(seen.cast<float>());
    EXPECT_LT((found.cast<double>() - expected).norm(), 1e-3);
    EXPECT_LT((ideal.to_pixel(expected).value() - seen).norm(), 1e-9);
    EXPECT_LT((ideal.ray_of(seen.cast<float>()).cast<double>() - point.head<2>() / point.z()).norm(), 1e-5);
  }
}

TEST(UndistortedCamera, WithoutDistortionIsTheSamePixelAndWithoutCalibrationHasNoRay) {
  Camera straight = distorted_camera();
  straight.distortion = Distortion::none;
  const Eigen::Vector2f pixel(123.25F, 45.5F);
  for (const UndistortedCamera& camera : {UndistortedCamera(std::nullopt), UndistortedCamera(straight)}) {
    EXPECT_TRUE(camera.is_identity());
    EXPECT_EQ(camera.from_pixel(pixel), pixel);
    EXPECT_EQ(camera.to_pixel(pixel.cast<double>()).value(), pixel.cast<double>());
  }
  EXPECT_FALSE(UndistortedCamera(distorted_camera()).is_identity());
  EXPECT_TRUE(std::isnan(UndistortedCamera(std::nullopt).ray_of(pixel).x()));
  const Eigen::Vector2f ray = UndistortedCamera(straight).ray_of(pixel);
  EXPECT_NEAR(static_cast<double>(ray.x()), (123.25 - straight.cx) / straight.fx, 1e-6);
  EXPECT_NEAR(static_cast<double>(ray.y()), (45.5 - straight.cy) / straight.fy, 1e-6);
}

}  // namespace
}  // namespace rastro
