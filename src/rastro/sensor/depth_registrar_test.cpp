// SPDX-License-Identifier: Apache-2.0
// Depth of a camera beside the color camera, against depth rendered at the color camera itself.
#include "rastro/sensor/depth_registrar.h"

#include <gtest/gtest.h>

#include "rastro/synthetic/renderer.h"

namespace rastro {
namespace {

/// A wall at 3 m, a slanted board, a thin pole and a box before it.
Scene room() {
  Scene scene;
  Material plain;
  plain.paint = [](Canvas&, Random&) {};
  scene.add_box({0.0, 0.0, 3.05}, {8.0, 6.0, 0.1}, plain);
  scene.add_box({0.0, 1.0, 2.0}, {8.0, 0.1, 4.0}, plain);
  scene.add_box({-0.5, 0.1, 1.6}, {0.5, 0.5, 0.05}, plain, 0.4);
  scene.add_box({0.45, 0.0, 1.2}, {0.3, 0.4, 0.3}, plain);
  scene.add_cylinder({0.1, 1.0, 1.0}, {0.1, -1.0, 1.0}, 0.03, plain);
  scene.make_tree();
  return scene;
}

struct Comparison {
  int compared = 0;    ///< Pixels inside a surface that the depth camera sees too.
  int missing = 0;     ///< Of these.
  int inexact = 0;     ///< Of these: off by more than a millimeter.
  int impossible = 0;  ///< Of all: depth that no pixel around has.
};

/// Whether the depth camera sees the point of a color pixel.
bool is_seen(const Scene& scene, const Camera& color, const DepthRegistration& registration, int x, int y, float z) {
  const auto ray = color.unproject({static_cast<double>(x), static_cast<double>(y)});
  const Eigen::Vector3d in_color = static_cast<double>(z) * Eigen::Vector3d(ray->x(), ray->y(), 1.0);
  const SE3 depth_from_color = registration.color_from_depth.inverse();
  const Eigen::Vector3d point = depth_from_color * in_color;
  const auto pixel = registration.depth_camera.project(point);
  if (!pixel || pixel->minCoeff() < 1.0 || pixel->x() > registration.depth_camera.width - 2.0 ||
      pixel->y() > registration.depth_camera.height - 2.0)
    return false;
  const Eigen::Vector3d origin = registration.color_from_depth.translation();
  const auto hit = scene.trace(origin, in_color - origin);
  return hit && hit->t > 0.999;
}

struct Range {
  float low, high;
};

/// Of the true depths around a pixel.
Range range_around(const DepthImage& truth, int x, int y) {
  Range range{truth.at(x, y), truth.at(x, y)};
  for (int dy = -2; dy <= 2; ++dy)
    for (int dx = -2; dx <= 2; ++dx) {
      range.low = std::min(range.low, truth.at(x + dx, y + dy));
      range.high = std::max(range.high, truth.at(x + dx, y + dy));
    }
  return range;
}

Comparison compare(const Scene& scene, const Camera& color, const DepthRegistration& registration) {
  TaskPool pool(1);
  const DepthImage truth = Renderer(scene, color).cast({}, pool).depth;
  const DepthImage raw = Renderer(scene, registration.depth_camera).cast(registration.color_from_depth, pool).depth;
  const DepthImage found = DepthRegistrar(registration, color).registered(raw);
  Comparison result;
  for (int y = 2; y < color.height - 2; ++y)
    for (int x = 2; x < color.width - 2; ++x) {
      const float z = found.at(x, y), z_true = truth.at(x, y);
      const auto [low, high] = range_around(truth, x, y);
      if (z > 0.0F && (z < low - 0.002F || z > high + 0.002F)) ++result.impossible;
      if (high - low > 0.1F || !is_seen(scene, color, registration, x, y, z_true)) continue;
      ++result.compared;
      if (z == 0.0F)
        ++result.missing;
      else if (std::abs(z - z_true) > 0.001F)
        ++result.inexact;
    }
  return result;
}

const Camera color{320, 240, 262.0, 262.0, 159.5, 119.5};

TEST(DepthRegistrarTest, TheSameCameraGivesTheSameDepth) {
  const Scene scene = room();
  TaskPool pool(1);
  DepthImage raw = Renderer(scene, color).cast({}, pool).depth;
  for (int y = 0; y < 40; ++y) std::fill(raw.row(y), raw.row(y) + 320, 0.0F);
  raw.at(160, 20) = 1.5F;  // alone
  const DepthImage found = DepthRegistrar({color, {}}, color).registered(raw);
  for (int y = 0; y < raw.height(); ++y)
    for (int x = 0; x < raw.width(); ++x) ASSERT_NEAR(found.at(x, y), raw.at(x, y), 2e-5F) << x << ' ' << y;
}

TEST(DepthRegistrarTest, DepthFromBesideIsThatOfTheColorCamera) {
  const Scene scene = room();
  const DepthRegistration kinect{{320, 240, 290.0, 290.0, 162.0, 118.0},
                                 SE3(SO3::exp({0.01, -0.02, 0.015}), {0.05, -0.004, 0.01})};
  const Comparison found = compare(scene, color, kinect);
  EXPECT_GT(found.compared, 50000);
  EXPECT_LT(found.missing, found.compared / 100) << "0.5 % beside the ends of surfaces";
  EXPECT_LT(found.inexact, found.compared / 150) << "the pole is round";
  EXPECT_LT(found.impossible, found.compared / 2000) << "the box hides the wall behind it";
}

TEST(DepthRegistrarTest, AFinerColorImageHasNoHoles) {
  const Scene scene = room();
  Camera fine = color.scaled(2.5);
  fine.distortion = Distortion::radial_tangential;
  fine.coefficients = {0.05, -0.1, 0.001, -0.0005, 0.02};
  const DepthRegistration kinect{
      {256, 212, 183.0, 183.0, 128.0, 106.0, Distortion::radial_tangential, {0.09, -0.27, 0.0, 0.0, 0.09}},
      SE3(SO3::exp({0.0, 0.01, 0.0}), {-0.052, 0.0, 0.0})};
  const Comparison found = compare(scene, fine, kinect);
  EXPECT_GT(found.compared, 400000);
  EXPECT_LT(found.missing, found.compared / 100) << "a reading of the depth camera is 3.6 pixels wide";
  EXPECT_LT(found.inexact, found.compared / 100);
  EXPECT_LT(found.impossible, found.compared / 2000);
}

}  // namespace
}  // namespace rastro
