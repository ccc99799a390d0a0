// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/epipolar_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "rastro/base/random.h"

namespace rastro {
namespace {

constexpr int width = 160, height = 120;

Camera pinhole() {
  Camera camera;
  camera.width = width, camera.height = height;
  camera.fx = camera.fy = 140.0, camera.cx = 79.5, camera.cy = 59.5;
  return camera;
}

/// Smooth and never the same twice, in pixels of the keyframe.
double paint(double u, double v) {
  return 128.0 + 45.0 * std::sin(0.31 * u + 0.07 * v) + 30.0 * std::sin(0.23 * v - 0.013 * u * std::sin(0.05 * u)) +
         20.0 * std::sin(0.57 * u - 0.2 * v);
}

/// A wall at depth 2 that faces the keyframe, as a camera at `image_from_keyframe` sees it.
GrayImage wall_from(const SE3& image_from_keyframe, double gain = 1.0, double offset = 0.0, double sigma = 0.0) {
  const Camera camera = pinhole();
  const SE3 keyframe_from_image = image_from_keyframe.inverse();
  GrayImage image(width, height);
  Random random(3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector3d ray = keyframe_from_image.rotation() *
                                  Eigen::Vector3d((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1.0);
      const Eigen::Vector3d& from = keyframe_from_image.translation();
      const Eigen::Vector3d point = from + (2.0 - from.z()) / ray.z() * ray;
      const double value =
          gain * paint(camera.fx * point.x() / 2.0 + camera.cx, camera.fy * point.y() / 2.0 + camera.cy);
      image.at(x, y) =
          static_cast<std::uint8_t>(std::lround(std::clamp(value + offset + sigma * random.normal(), 0.0, 255.0)));
    }
  return image;
}

struct Found {
  int matched = 0, all = 0;
  std::vector<double> errors;  ///< Inverse depth less the true one, in standard deviations.
  double worst = 0.0;          ///< Relative to the true one.
};

Found search(const SE3& image_from_keyframe, double gain, double offset, double sigma, double least, double most) {
  const GrayImage keyframe = wall_from(SE3(), 1.0, 0.0, sigma),
                  image = wall_from(image_from_keyframe, gain, offset, sigma);
  EpipolarSearchOptions options;
  options.intensity_sigma = std::max(1.0, sigma);
  const EpipolarSearch search(keyframe.view(), image.view(), pinhole(), image_from_keyframe, gain, offset, options);
  Found found;
  for (int y = 20; y < height - 20; y += 3)
    for (int x = 30; x < width - 30; x += 3) {
      const EpipolarMatch match = search.find(x, y, {least, 0.5 * (least + most), most});
      ++found.all;
      if (match.result != EpipolarResult::matched) continue;
      ++found.matched;
      const double error = static_cast<double>(match.mean) - 0.5;
      found.errors.push_back(error / std::sqrt(static_cast<double>(match.variance)));
      found.worst = std::max(found.worst, std::abs(error) / 0.5);
    }
  return found;
}

TEST(EpipolarSearch, FindsTheTrueDepthForMotionInAnyDirection) {
  const SE3 motions[] = {SE3(SO3(), {0.15, 0.0, 0.0}), SE3(SO3(), {0.0, -0.15, 0.0}),
                         SE3(SO3::exp({0.02, -0.03, 0.05}), {-0.1, 0.08, 0.05})};
  for (const SE3& motion : motions) {
    const Found found = search(motion, 1.0, 0.0, 0.0, 0.3, 0.8);
    EXPECT_GT(found.matched, found.all / 4);
    EXPECT_LT(found.worst, 0.08) << motion.translation().transpose();
  }
}

TEST(EpipolarSearch, AnotherBrightnessMakesNoDifference) {
  for (const auto& [gain, offset] : {std::pair{0.5, 10.0}, {1.3, -30.0}}) {
    const Found found = search(SE3(SO3(), {0.15, 0.0, 0.0}), gain, offset, 0.0, 0.3, 0.8);
    EXPECT_GT(found.matched, found.all / 4) << gain;
    EXPECT_LT(found.worst, 0.1) << gain;
  }
}

/// The least deviation of a disparity is on the safe side for images as sharp as these.
TEST(EpipolarSearch, TheVarianceIsThatOfTheErrors) {
  const Found found = search(SE3(SO3(), {0.2, 0.05, 0.0}), 1.0, 0.0, 3.0, 0.35, 0.7);
  ASSERT_GT(found.errors.size(), 100U);
  double squares = 0.0;
  for (const double error : found.errors) squares += error * error;
  const double mean = squares / static_cast<double>(found.errors.size());
  EXPECT_GT(mean, 0.05);
  EXPECT_LT(mean, 1.2);
}

TEST(EpipolarSearch, SaysWhyThereIsNoDepth) {
  const GrayImage keyframe = wall_from(SE3());
  GrayImage flat(width, height), other = wall_from(SE3(SO3::exp({0.0, 0.0, 1.5}), {0.3, 0.3, 0.0}));
  for (int y = 0; y < height; ++y) std::fill(flat.row(y), flat.row(y) + width, std::uint8_t{90});
  const auto result = [&](const GrayImage& from, const GrayImage& to, const SE3& motion) {
    return EpipolarSearch(from.view(), to.view(), pinhole(), motion, 1.0, 0.0, {}).find(80, 60, {0.3, 0.5, 0.8}).result;
  };
  const SE3 aside(SO3(), {0.15, 0.0, 0.0});
  EXPECT_EQ(result(keyframe, keyframe, SE3()), EpipolarResult::short_line);
  EXPECT_EQ(result(flat, flat, aside), EpipolarResult::flat);
  EXPECT_EQ(result(keyframe, flat, aside), EpipolarResult::poor_match);
  const EpipolarSearch sure(keyframe.view(), other.view(), pinhole(), aside, 1.0, 0.0, {});
  EXPECT_EQ(sure.find(80, 60, {0.3, 0.5, 0.8, true, 1e-6}).result, EpipolarResult::no_news);
  EXPECT_EQ(result(keyframe, keyframe, SE3(SO3(), {5.0, 0.0, 0.0})), EpipolarResult::outside);
  EXPECT_EQ(result(keyframe, keyframe, SE3(SO3(), {0.0, 0.0, -3.0})), EpipolarResult::behind);
}

}  // namespace
}  // namespace rastro
