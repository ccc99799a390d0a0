// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/orb.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "rastro/base/error.h"
#include "rastro/base/random.h"
#include "rastro/base/simd_testing.h"
#include "rastro/feature/fast.h"
#include "rastro/feature/orb_blur.h"
#include "rastro/feature/orb_resize.h"
#include "rastro/feature/orb_spread.h"

namespace rastro {
namespace {

/// Rectangles of random grey over each other, and noise: corners of all sizes.
GreyImage blocks(int width, int height, std::uint64_t seed, double noise = 3.0) {
  Random random(seed);
  cv::Mat picture(height, width, CV_32F, cv::Scalar(128.0));
  for (int i = 0; i < width * height / 400; ++i) {
    const auto side = static_cast<float>(4.0 * std::exp(3.0 * random.uniform()));
    const cv::RotatedRect box(
        {static_cast<float>(random.uniform(0, width)), static_cast<float>(random.uniform(0, height))},
        {side, side * static_cast<float>(random.uniform(0.4, 2.0))}, static_cast<float>(random.uniform(0, 90)));
    cv::Point2f corners[4];
    box.points(corners);
    std::vector<cv::Point> polygon;
    for (const auto& corner : corners) polygon.emplace_back(cvRound(corner.x), cvRound(corner.y));
    cv::fillConvexPoly(picture, polygon, cv::Scalar(random.uniform(0.0, 255.0)));
  }
  GreyImage image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.at(x, y) = cv::saturate_cast<std::uint8_t>(picture.at<float>(y, x) + noise * random.normal());
  return image;
}

PaddedImage padded(const GreyImage& image) {
  PaddedImage result;
  result.reset(image.width(), image.height(), fast_padding);
  for (int y = 0; y < image.height(); ++y) std::copy_n(image.row(y), image.width(), result.row(y));
  result.fill_padding();
  return result;
}

cv::Mat as_mat(GreyView image) {
  return {image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
          static_cast<std::size_t>(image.stride)};
}

bool same(const OrbFeatures& a, const OrbFeatures& b) {
  const auto equal = [](const Keypoint& p, const Keypoint& q) {
    return p.x == q.x && p.y == q.y && p.size_px == q.size_px && p.angle_rad == q.angle_rad && p.response == q.response;
  };
  return a.levels == b.levels && a.descriptors == b.descriptors &&
         std::equal(a.keypoints.begin(), a.keypoints.end(), b.keypoints.begin(), b.keypoints.end(), equal);
}

TEST(Fast, FindsWhatOpenCvFinds) {
  const GreyImage image = blocks(211, 130, 1);
  for (const int threshold : {7, 20, 60}) {
    std::vector<cv::KeyPoint> expected;
    cv::FAST(as_mat(image), expected, threshold, false);
    std::vector<FastCorner> corners;
    fast_corners(padded(image), 3, 208, 3, 127, threshold, corners);
    ASSERT_GT(corners.size(), 20U);
    for (const FastCorner& corner : corners)
      EXPECT_TRUE(std::any_of(expected.begin(), expected.end(), [&](const cv::KeyPoint& point) {
        return point.pt == cv::Point2f(corner.x, corner.y);
      })) << threshold;
    // OpenCV drops both of two equal neighbours, so it has fewer, at scores that are one less by its definition.
    cv::FAST(as_mat(image), expected, threshold, true);
    EXPECT_LE(expected.size(), corners.size());
    for (const cv::KeyPoint& point : expected) {
      if (point.pt.x < 4 || point.pt.x > 206 || point.pt.y < 4 || point.pt.y > 125) continue;  // It looks no farther.
      EXPECT_TRUE(std::any_of(corners.begin(), corners.end(), [&](const FastCorner& corner) {
        return point.pt == cv::Point2f(corner.x, corner.y) && point.response == static_cast<float>(corner.score - 1);
      })) << threshold << " " << point.pt;
    }
  }
}

TEST(Fast, FindsTheSameInBandsAsAtOnce) {
  const PaddedImage image = padded(blocks(150, 97, 2));
  std::vector<FastCorner> whole, bands;
  fast_corners(image, 16, 134, 16, 81, 7, whole);
  for (int y = 16; y < 81; y += 5) fast_corners(image, 16, 134, y, std::min(81, y + 5), 7, bands);
  ASSERT_EQ(bands.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i)
    EXPECT_EQ(std::pair(bands[i].x, bands[i].y), std::pair(whole[i].x, whole[i].y));
}

TEST(OrbBlur, IsAGaussianOfTwoPixels) {
  const GreyImage image = blocks(101, 67, 3);
  GreyImage blurred(101, 67);
  orb_blur(padded(image), blurred, 0, 67);
  cv::Mat expected;
  cv::GaussianBlur(as_mat(image), expected, {7, 7}, 2.0, 2.0, cv::BORDER_REFLECT_101);
  double worst = 0.0;
  cv::minMaxLoc(cv::abs(as_mat(blurred) - expected), nullptr, &worst);
  EXPECT_LE(cv::norm(as_mat(blurred), expected, cv::NORM_INF), 3.0);
}

TEST(OrbResize, KeepsPlaces) {
  for (const double factor : {1.1, 1.2, 1.5, 2.0}) {
    PaddedImage ramp;
    ramp.reset(120, 80, fast_padding);
    for (int y = 0; y < 80; ++y)
      for (int x = 0; x < 120; ++x) ramp.row(y)[x] = static_cast<std::uint8_t>(x + y);
    ramp.fill_padding();
    const OrbResize resize(120, 80, factor);
    PaddedImage small;
    small.reset(resize.width(), resize.height(), fast_padding);
    resize.run(ramp, small, 0, resize.height());
    for (int y = 0; y < resize.height() - 1; ++y)
      for (int x = 0; x < resize.width() - 1; ++x)
        ASSERT_NEAR(small.row(y)[x], (x + 0.5) * factor - 0.5 + (y + 0.5) * factor - 0.5, 0.52) << factor;
  }
}

TEST(Orb, IsTheSameByAnyCodeAndPool) {
  TaskPool pool(3);
  for (const auto& [width, height] : {std::pair(320, 240), std::pair(333, 217)}) {
    const GreyImage image = blocks(width, height, 4);
    const OrbFeatures features = OrbExtractor({}).extract(image.view());
    ASSERT_GT(features.size(), 500U);
    EXPECT_TRUE(
        same(features, rastro::testing::with_plain_code([&] { return OrbExtractor({}).extract(image.view()); })));
    EXPECT_TRUE(same(features, OrbExtractor({}).extract(image.view(), {}, &pool)));
  }
}

TEST(Orb, ForgetsThePictureBefore) {
  const GreyImage first = blocks(300, 200, 5), second = blocks(260, 210, 6);
  OrbExtractor extractor({});
  extractor.extract(first.view());
  EXPECT_TRUE(same(extractor.extract(second.view()), OrbExtractor({}).extract(second.view())));
}

}  // namespace
}  // namespace rastro
