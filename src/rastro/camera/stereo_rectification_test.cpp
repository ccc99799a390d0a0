// SPDX-License-Identifier: Apache-2.0
#include "rastro/camera/stereo_rectification.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rastro {
namespace {

Camera lens(double focal) {
  Camera camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = focal;
  camera.fy = focal + 1.0;
  camera.cx = 163.0;
  camera.cy = 117.5;
  camera.distortion = Distortion::radial_tangential;
  camera.coefficients = {-0.28, 0.07, 0.0002, 0.00002, 0.0};
  return camera;
}

SE3 rotated_pair() { return {SO3::exp({0.02, -0.03, 0.015}), {0.11, 0.002, -0.004}}; }

/// Image of a far wall, whose pattern is known everywhere, in a camera at `camera_from_wall`.
GrayImage image_of_wall(const Camera& camera, const SE3& wall_from_camera) {
  GrayImage image(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const auto ray = camera.unproject({x, y});
      if (!ray) continue;
      const Eigen::Vector3d direction = wall_from_camera.rotation() * Eigen::Vector3d(ray->x(), ray->y(), 1.0);
      const Eigen::Vector3d& center = wall_from_camera.translation();
      const Eigen::Vector3d at = center + direction * ((3.0 - center.z()) / direction.z());
      image.at(x, y) = static_cast<std::uint8_t>(
          std::lround(128.0 + 50.0 * std::sin(6.0 * at.x()) + 50.0 * std::sin(7.0 * at.y() + at.x())));
    }
  }
  return image;
}

TEST(StereoRectification, ImagesAreThoseOfTheRectifiedPair) {
  const Camera left = lens(230.0), right = lens(228.0);
  const SE3 left_from_right = rotated_pair();
  const auto made = rectify_stereo(left, right, left_from_right);
  ASSERT_TRUE(made);
  EXPECT_NEAR(made->baseline, left_from_right.translation().norm(), 1e-12);
  const SE3 left_from_rectified_ideal(made->left_from_rectified, Eigen::Vector3d::Zero());
  const SE3 left_from_ideal_right(made->left_from_rectified, left_from_right.translation());
  const struct {
    GrayImage warped, ideal;
    const UndistortMap& map;
  } pairs[] = {{remap(image_of_wall(left, SE3()), made->left), image_of_wall(made->camera, left_from_rectified_ideal),
                made->left},
               {remap(image_of_wall(right, left_from_right), made->right),
                image_of_wall(made->camera, left_from_ideal_right), made->right}};
  for (const auto& pair : pairs) {
    const GrayImage shown = shown_by(pair.map, 320, 240, 0);
    int compared = 0;
    for (int y = 0; y < shown.height(); ++y) {
      for (int x = 0; x < shown.width(); ++x) {
        if (shown.at(x, y) == 0) continue;
        ++compared;
        ASSERT_NEAR(pair.warped.at(x, y), pair.ideal.at(x, y), 3) << x << ", " << y;
      }
    }
    EXPECT_GT(compared, 320 * 240 * 8 / 10) << "most of the image is used";
  }
}

TEST(StereoRectification, EpipolarLinesAreRowsAndDisparityGivesDepth) {
  const Camera left = lens(230.0), right = lens(228.0);
  const SE3 left_from_right = rotated_pair();
  const auto made = rectify_stereo(left, right, left_from_right);
  ASSERT_TRUE(made);
  const SE3 right_from_left = left_from_right.inverse();
  for (const Eigen::Vector3d& point : {Eigen::Vector3d(0.1, 0.2, 2.0), Eigen::Vector3d(-0.5, 0.3, 5.0)}) {
    const Eigen::Vector3d in_left = made->left_from_rectified.inverse() * point;
    const Eigen::Vector3d from_right = left_from_right.rotation() * Eigen::Vector3d(right_from_left * point);
    const Eigen::Vector3d in_right = made->left_from_rectified.inverse() * from_right;
    const auto a = made->camera.project(in_left), b = made->camera.project(in_right);
    ASSERT_TRUE(a && b);
    EXPECT_NEAR(a->y(), b->y(), 1e-9);
    EXPECT_NEAR(a->x() - b->x(), made->camera.fx * made->baseline / in_left.z(), 1e-9);
  }
}

TEST(StereoRectification, TheImagedAreaShrinksByItsMargin) {
  const Camera camera = lens(230.0);
  const auto aside = rectify_stereo(camera, camera, SE3(SO3::exp({0.0, 0.5, 0.0}), {0.1, 0.0, 0.0}));
  ASSERT_TRUE(aside);
  const GrayImage narrow = shown_by(aside->left, 320, 240, 4), wide = shown_by(aside->left, 320, 240, 0);
  int shown = 0, hidden = 0;
  for (int y = 4; y < 236; ++y) {
    for (int x = 4; x < 316; ++x) {
      bool all = true;
      for (int dy = -4; dy <= 4; ++dy)
        for (int dx = -4; dx <= 4; ++dx) all = all && wide.at(x + dx, y + dy) != 0;
      ASSERT_EQ(narrow.at(x, y) != 0, all) << x << ", " << y;
      (all ? shown : hidden)++;
    }
  }
  EXPECT_GT(shown, 10000);
  EXPECT_GT(hidden, 1000);
}

TEST(StereoRectification, AnyPoolMakesTheSameBytes) {
  const Camera camera = lens(230.0);
  const auto made = rectify_stereo(camera, camera, rotated_pair());
  ASSERT_TRUE(made);
  const GrayImage image = image_of_wall(camera, SE3());
  TaskPool three(3);
  const GrayImage alone = remap(image, made->left), together = remap(image, made->left, &three);
  for (int y = 0; y < 240; ++y) EXPECT_TRUE(std::equal(alone.row(y), alone.row(y) + 320, together.row(y)));
}

TEST(StereoRectification, RefusesCamerasThatAreNotSideBySide) {
  const Camera camera = lens(230.0);
  Camera other = camera, unknown = camera;
  other.width = 640;
  unknown.width = 0;
  EXPECT_FALSE(rectify_stereo(camera, other, rotated_pair()));
  EXPECT_FALSE(rectify_stereo(unknown, unknown, rotated_pair()));
  EXPECT_FALSE(rectify_stereo(camera, camera, SE3()));
  EXPECT_FALSE(rectify_stereo(camera, camera, SE3(SO3(), {0.0, 0.1, 0.0})));
  EXPECT_FALSE(rectify_stereo(camera, camera, SE3(SO3::exp({0.0, 1.0, 0.0}), {0.1, 0.0, 0.0})));
}

}  // namespace
}  // namespace rastro
