// SPDX-License-Identifier: Apache-2.0
#include "rastro/camera/undistort_map.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "rastro/base/random.h"

namespace rastro {
namespace {

Camera euroc() {
  return {752,
          480,
          458.654,
          457.296,
          367.215,
          248.375,
          Distortion::radial_tangential,
          {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}};
}

Camera fisheye() {
  return {
      512, 512, 190.978, 190.973, 254.93, 256.897, Distortion::equidistant, {0.00348, 0.000715, -0.00205, 0.000203}};
}

cv::Matx33d matrix_of(const Camera& camera) { return {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1}; }

struct OpenCvMaps {
  cv::Mat x, y;
};

OpenCvMaps opencv_maps(const Camera& camera, const Camera& undistorted) {
  OpenCvMaps maps;
  const auto& k = camera.coefficients;
  const cv::Size size(undistorted.width, undistorted.height);
  if (camera.distortion == Distortion::equidistant)
    cv::fisheye::initUndistortRectifyMap(matrix_of(camera), cv::Vec4d(k[0], k[1], k[2], k[3]), cv::Matx33d::eye(),
                                         matrix_of(undistorted), size, CV_32FC1, maps.x, maps.y);
  else
    cv::initUndistortRectifyMap(matrix_of(camera), std::vector<double>(k.begin(), k.end()), cv::Mat(),
                                matrix_of(undistorted), size, CV_32FC1, maps.x, maps.y);
  return maps;
}

TEST(UndistortMap, IsThatOfOpenCv) {
  for (const Camera& camera : {euroc(), fisheye()})
    for (const double alpha : {0.0, 0.5}) {
      const UndistortMap map = undistort_map(camera, alpha);
      const OpenCvMaps expected = opencv_maps(camera, map.camera);
      int without_source = 0;
      for (int y = 0; y < map.camera.height; ++y)
        for (int x = 0; x < map.camera.width; ++x) {
          if (std::isnan(map.x.at(x, y))) {
            ++without_source;
            continue;
          }
          ASSERT_NEAR(map.x.at(x, y), expected.x.at<float>(y, x), 2e-4) << x << " " << y;
          ASSERT_NEAR(map.y.at(x, y), expected.y.at<float>(y, x), 2e-4) << x << " " << y;
        }
      EXPECT_EQ(without_source, 0);
    }
}

TEST(UndistortMap, AlphaZeroShowsOnlyRecordedPixels) {
  for (const Camera& camera : {euroc(), fisheye()}) {
    const UndistortMap map = undistort_map(camera, 0.0);
    double nearest = 1e9;
    for (int y = 0; y < map.camera.height; ++y)
      for (int x = 0; x < map.camera.width; ++x) {
        const float from_x = map.x.at(x, y), from_y = map.y.at(x, y);
        ASSERT_TRUE(from_x >= -1e-3F && from_y >= -1e-3F && from_x <= static_cast<float>(camera.width) - 0.999F &&
                    from_y <= static_cast<float>(camera.height) - 0.999F)
            << x << " " << y << " comes from " << from_x << " " << from_y;
        nearest = std::min({nearest, double{from_x}, double{from_y}});
      }
    // Rays of the fisheye more than 80 degrees off the axis (the corners) do not count.
    EXPECT_LT(nearest, camera.distortion == Distortion::equidistant ? 3.0 : 1.0)
        << "and the rectangle touches the border";
  }
}

TEST(UndistortMap, AlphaOneShowsEveryRecordedPixel) {
  const Camera camera = euroc(), undistorted = undistorted_camera(camera, 1.0);
  for (int y = 0; y < camera.height; y += 7)
    for (int x = 0; x < camera.width; x += 7) {
      const auto ray = camera.unproject({x, y});
      ASSERT_TRUE(ray);
      const auto shown = undistorted.project(ray->homogeneous());
      EXPECT_TRUE(shown->x() >= -1e-6 && shown->y() >= -1e-6 && shown->x() <= camera.width - 1 + 1e-6 &&
                  shown->y() <= camera.height - 1 + 1e-6)
          << shown->transpose();
    }
}

TEST(UndistortMap, NewCameraIsNearOpenCvs) {
  const Camera camera = euroc();
  const auto& k = camera.coefficients;
  for (const double alpha : {0.0, 1.0}) {
    const Camera ours = undistorted_camera(camera, alpha);
    const cv::Mat theirs = cv::getOptimalNewCameraMatrix(matrix_of(camera), std::vector<double>(k.begin(), k.end()),
                                                         {camera.width, camera.height}, alpha);
    // OpenCV checks 9 x 9 points, we check the whole border.
    EXPECT_NEAR(ours.fx, theirs.at<double>(0, 0), 0.02 * ours.fx);
    EXPECT_NEAR(ours.fy, theirs.at<double>(1, 1), 0.02 * ours.fy);
    EXPECT_NEAR(ours.cx, theirs.at<double>(0, 2), 8.0);
    EXPECT_NEAR(ours.cy, theirs.at<double>(1, 2), 8.0);
  }
}

TEST(UndistortMap, WithoutDistortionNothingChanges) {
  const Camera camera{64, 48, 60.0, 61.0, 31.0, 25.0, Distortion::none, {}};
  GrayImage image(64, 48);
  Random random(3);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) image.at(x, y) = static_cast<std::uint8_t>(random.below(256));
  const GrayImage result = remap(image, undistort_map(camera, 0.3));
  for (int y = 1; y < 47; ++y)
    for (int x = 1; x < 63; ++x) ASSERT_EQ(result.at(x, y), image.at(x, y)) << x << " " << y;
}

TEST(UndistortMap, RemapIsBilinear) {
  const Camera camera = euroc();
  cv::Mat recorded(camera.height, camera.width, CV_8U);
  cv::RNG generator(5);
  generator.fill(recorded, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(recorded, recorded, {5, 5}, 1.5);
  const UndistortMap map = undistort_map(camera, 1.0);
  const OpenCvMaps maps = opencv_maps(camera, map.camera);
  cv::Mat expected;
  cv::remap(recorded, expected, maps.x, maps.y, cv::INTER_LINEAR);
  const GrayImage result = remap({recorded.data, recorded.cols, recorded.rows, recorded.cols}, map);
  int compared = 0;
  for (int y = 0; y < result.height(); ++y)
    for (int x = 0; x < result.width(); ++x) {
      const float from_x = map.x.at(x, y), from_y = map.y.at(x, y);
      const bool inside = from_x > 1.0F && from_y > 1.0F && from_x < static_cast<float>(camera.width - 2) &&
                          from_y < static_cast<float>(camera.height - 2);
      if (!inside) continue;
      ++compared;
      // OpenCV rounds the position to 1/32 of a pixel.
      ASSERT_NEAR(result.at(x, y), expected.at<std::uint8_t>(y, x), 4) << x << " " << y;
    }
  EXPECT_GT(compared, 200000);
}

TEST(UndistortMap, OutsideTheRecordedImageIsBlack) {
  const Camera camera = euroc();
  GrayImage white(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) white.at(x, y) = 255;
  const GrayImage result = remap(white, undistort_map(camera, 1.0));
  EXPECT_EQ(result.at(result.width() / 2, 0), 0);
  EXPECT_EQ(result.at(result.width() / 2, result.height() / 2), 255);
}

}  // namespace
}  // namespace rastro
