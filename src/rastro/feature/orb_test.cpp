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
#include "rastro/feature/descriptor_matching.h"
#include "rastro/feature/fast.h"
#include "rastro/feature/orb_blur.h"
#include "rastro/feature/orb_resize.h"
#include "rastro/feature/orb_spread.h"

namespace rastro {
namespace {

/// Overlapping rectangles of random intensity, and noise: corners of all sizes.
GrayImage blocks(int width, int height, std::uint64_t seed, double noise = 3.0) {
  Random random(seed);
  cv::Mat canvas(height, width, CV_32F, cv::Scalar(128.0));
  for (int i = 0; i < width * height / 400; ++i) {
    const auto side = static_cast<float>(4.0 * std::exp(3.0 * random.uniform()));
    const cv::RotatedRect box(
        {static_cast<float>(random.uniform(0, width)), static_cast<float>(random.uniform(0, height))},
        {side, side * static_cast<float>(random.uniform(0.4, 2.0))}, static_cast<float>(random.uniform(0, 90)));
    cv::Point2f corners[4];
    box.points(corners);
    std::vector<cv::Point> polygon;
    for (const auto& corner : corners) polygon.emplace_back(cvRound(corner.x), cvRound(corner.y));
    cv::fillConvexPoly(canvas, polygon, cv::Scalar(random.uniform(0.0, 255.0)));
  }
  GrayImage image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.at(x, y) = cv::saturate_cast<std::uint8_t>(canvas.at<float>(y, x) + noise * random.normal());
  return image;
}

PaddedImage padded(const GrayImage& image) {
  PaddedImage result;
  result.reset(image.width(), image.height(), fast_padding);
  for (int y = 0; y < image.height(); ++y) std::copy_n(image.row(y), image.width(), result.row(y));
  result.fill_padding();
  return result;
}

cv::Mat as_mat(GrayView image) {
  return {image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
          static_cast<std::size_t>(image.stride)};
}

bool same(const Features& a, const Features& b) {
  const auto equal = [](const Keypoint& p, const Keypoint& q) {
    return p.x == q.x && p.y == q.y && p.size_px == q.size_px && p.angle_rad == q.angle_rad && p.response == q.response;
  };
  return a.levels == b.levels && a.descriptors == b.descriptors &&
         std::equal(a.keypoints.begin(), a.keypoints.end(), b.keypoints.begin(), b.keypoints.end(), equal);
}

TEST(Fast, AgreesWithOpenCv) {
  const GrayImage image = blocks(211, 130, 1);
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
    // OpenCV drops both of two equal neighbors, so it has fewer, with scores that are one less by its definition.
    cv::FAST(as_mat(image), expected, threshold, true);
    EXPECT_LE(expected.size(), corners.size());
    for (const cv::KeyPoint& point : expected) {
      if (point.pt.x < 4 || point.pt.x > 206 || point.pt.y < 4 || point.pt.y > 125)
        continue;  // It searches no farther.
      EXPECT_TRUE(std::any_of(corners.begin(), corners.end(),
                              [&](const FastCorner& corner) {
                                return point.pt == cv::Point2f(corner.x, corner.y) &&
                                       point.response == static_cast<float>(corner.score - 1);
                              }))
          << threshold << " " << point.pt;
    }
  }
}

TEST(Fast, GivesTheSameInBandsAsInOnePass) {
  const PaddedImage image = padded(blocks(150, 97, 2));
  std::vector<FastCorner> whole, bands;
  fast_corners(image, 16, 134, 16, 81, 7, whole);
  for (int y = 16; y < 81; y += 5) fast_corners(image, 16, 134, y, std::min(81, y + 5), 7, bands);
  ASSERT_EQ(bands.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i)
    EXPECT_EQ(std::pair(bands[i].x, bands[i].y), std::pair(whole[i].x, whole[i].y));
}

TEST(OrbBlur, IsAGaussianOfTwoPixels) {
  const GrayImage image = blocks(101, 67, 3);
  GrayImage blurred(101, 67);
  orb_blur(padded(image), blurred, 0, 67);
  cv::Mat expected;
  cv::GaussianBlur(as_mat(image), expected, {7, 7}, 2.0, 2.0, cv::BORDER_REFLECT_101);
  EXPECT_LE(cv::norm(as_mat(blurred), expected, cv::NORM_INF), 3.0);
}

TEST(OrbResize, KeepsPositions) {
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

TEST(Orb, IsTheSameForAnyCodeAndPool) {
  TaskPool pool(3);
  for (const auto& [width, height] : {std::pair(320, 240), std::pair(333, 217)}) {
    const GrayImage image = blocks(width, height, 4);
    const Features features = OrbExtractor({}).extract(image.view());
    ASSERT_GT(features.size(), 500U);
    EXPECT_TRUE(
        same(features, rastro::testing::with_plain_code([&] { return OrbExtractor({}).extract(image.view()); })));
    EXPECT_TRUE(same(features, OrbExtractor({}).extract(image.view(), {}, &pool)));
  }
}

/// The image rotated about its center, magnified and shifted; sampled bilinearly.
GrayImage moved(const GrayImage& image, const cv::Mat& to_moved) {
  cv::Mat warped;
  cv::warpAffine(as_mat(image), warped, to_moved, {image.width(), image.height()}, cv::INTER_LINEAR,
                 cv::BORDER_REFLECT);
  GrayImage result(image.width(), image.height());
  for (int y = 0; y < image.height(); ++y) std::copy_n(warped.ptr(y), image.width(), result.row(y));
  return result;
}

struct MatchFigures {
  int matches = 0, right = 0;
  double median_error_px = 0.0;  ///< Of the correct ones.
};

/// Mutual nearest neighbors with a ratio test, against their true positions.
MatchFigures match(const Features& first, const Features& second, const cv::Mat& second_from_first) {
  const auto described = [](const Features& features) {
    Features result;
    result.keypoints = features.keypoints;
    result.descriptors = features.descriptors;
    return result;
  };
  MatchFigures figures;
  std::vector<double> errors;
  for (const auto& pair : match_descriptors(described(first), described(second), {})) {
    const Keypoint &a = first.keypoints[pair.first], &b = second.keypoints[pair.second];
    const cv::Mat at = second_from_first * (cv::Mat_<double>(3, 1) << a.x, a.y, 1.0);
    const double error =
        std::hypot(at.at<double>(0) - static_cast<double>(b.x), at.at<double>(1) - static_cast<double>(b.y));
    ++figures.matches;
    if (error < 0.1 * static_cast<double>(a.size_px)) errors.push_back(error);
  }
  figures.right = static_cast<int>(errors.size());
  if (errors.empty()) return figures;
  std::nth_element(errors.begin(), errors.begin() + figures.right / 2, errors.end());
  figures.median_error_px = errors[errors.size() / 2];
  return figures;
}

TEST(Orb, MatchesUnderRotationAndMagnification) {
  const GrayImage image = blocks(420, 320, 7, 1.0);
  const Features features = OrbExtractor({}).extract(image.view());
  for (const auto& [degrees, scale] :
       {std::pair(3.0, 1.0), std::pair(40.0, 1.0), std::pair(171.0, 0.8), std::pair(-75.0, 1.3)}) {
    const cv::Mat to_moved = cv::getRotationMatrix2D({209.5F, 159.5F}, degrees, scale);
    const auto figures = match(features, OrbExtractor({}).extract(moved(image, to_moved).view()), to_moved);
    EXPECT_GT(figures.matches, 150) << degrees;
    EXPECT_GT(figures.right, 0.9 * figures.matches) << degrees;
    EXPECT_LT(figures.median_error_px, 0.9) << degrees;
  }
}

TEST(Orb, PositionsAreRightOnAllLevels) {
  const GrayImage image = blocks(420, 320, 8, 1.0);
  const cv::Mat to_moved = (cv::Mat_<double>(2, 3) << 1, 0, 7.3, 0, 1, -4.6);
  const auto figures =
      match(OrbExtractor({}).extract(image.view()), OrbExtractor({}).extract(moved(image, to_moved).view()), to_moved);
  EXPECT_GT(figures.right, 250);
  EXPECT_LT(figures.median_error_px, 0.5);
}

TEST(Orb, OrientationRotatesWithTheImage) {
  const GrayImage image = blocks(300, 300, 9, 2.0);
  GrayImage quarter(300, 300);  // (x, y) moves to (299 - y, x): 90 degrees from x towards y.
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 300; ++x) quarter.at(299 - y, x) = image.at(x, y);
  OrbOptions options;
  options.levels = 1;
  options.features = 100000;
  const Features before = OrbExtractor(options).extract(image.view());
  const Features after = OrbExtractor(options).extract(quarter.view());
  int found = 0, rotated = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    for (std::size_t j = 0; j < after.size(); ++j) {
      if (std::abs(after.keypoints[j].x - (299.0F - before.keypoints[i].y)) > 0.01F ||
          std::abs(after.keypoints[j].y - before.keypoints[i].x) > 0.01F)
        continue;
      ++found;
      const double by = static_cast<double>(after.keypoints[j].angle_rad - before.keypoints[i].angle_rad);
      rotated += std::abs(std::remainder(by - std::numbers::pi / 2, 2 * std::numbers::pi)) < 1e-5 &&
                 hamming_distance(before.descriptors[i], after.descriptors[j]) <= 12;
    }
  }
  // Of two equal neighbors another one is selected in the rotated image.
  EXPECT_GT(found, 0.9 * static_cast<double>(before.size()));
  EXPECT_GT(rotated, 0.9 * found);
}

TEST(Orb, SpreadsOverTheImage) {
  // Strong corners in the left half, weak ones in the right half.
  GrayImage image = blocks(400, 300, 10, 0.0);
  for (int y = 0; y < 300; ++y)
    for (int x = 200; x < 400; ++x) image.at(x, y) = static_cast<std::uint8_t>(100 + image.at(x, y) / 4);
  OrbOptions options;
  options.features = 500;
  const Features features = OrbExtractor(options).extract(image.view());
  const auto right = std::count_if(features.keypoints.begin(), features.keypoints.end(),
                                   [](const Keypoint& keypoint) { return keypoint.x > 200.0F; });
  EXPECT_EQ(features.size(), 500U);
  EXPECT_GT(right, 125);
  EXPECT_LT(right, 375);
  for (std::uint8_t level = 0; level < 8; ++level)
    EXPECT_GT(std::count(features.levels.begin(), features.levels.end(), level), 20) << int{level};
}

TEST(Orb, SkipsMaskedAreas) {
  const GrayImage image = blocks(300, 200, 11);
  GrayImage mask(300, 200);
  for (int y = 0; y < 200; ++y) std::fill_n(mask.row(y) + 120, 180, std::uint8_t{255});
  const Features features = OrbExtractor({}).extract(image.view(), mask.view());
  ASSERT_GT(features.size(), 100U);
  for (std::size_t i = 0; i < features.size(); ++i)
    EXPECT_GT(features.keypoints[i].x, 119.0 - std::pow(1.2, features.levels[i]));
}

TEST(Orb, BlankAndTinyImagesHaveFewOrNoFeatures) {
  OrbExtractor extractor({});
  EXPECT_EQ(extractor.extract(GrayImage(200, 150).view()).size(), 0U);
  EXPECT_EQ(extractor.extract(blocks(20, 300, 12).view()).size(), 0U);
  EXPECT_EQ(extractor.extract({}).size(), 0U);
  const Features few = extractor.extract(blocks(60, 60, 13).view());
  EXPECT_LT(few.levels.empty() ? 0 : *std::max_element(few.levels.begin(), few.levels.end()), 3);
}

TEST(Orb, RefusesWrongOptions) {
  OrbOptions many, shallow, flat, loose;
  many.features = 0;
  shallow.levels = 0;
  flat.scale_factor = 1.0;
  loose.least_fast_threshold = 30;
  for (const OrbOptions& options : {many, shallow, flat, loose}) EXPECT_THROW(OrbExtractor{options}, Error);
}

TEST(OrbQuotas, WhatALevelCannotFillGoesToOthers) {
  EXPECT_EQ(orb_quotas(100, 2.0, {500, 500}), (std::vector<std::size_t>{67, 33}));
  EXPECT_EQ(orb_quotas(100, 2.0, {500, 3}), (std::vector<std::size_t>{97, 3}));
  EXPECT_EQ(orb_quotas(100, 2.0, {10, 500}), (std::vector<std::size_t>{10, 90}));
  EXPECT_EQ(orb_quotas(100, 2.0, {1, 2}), (std::vector<std::size_t>{1, 2}));
}

TEST(Orb, TheNumberOfFeaturesMayChangeFromImageToImage) {
  const GrayImage image = blocks(300, 200, 5);
  OrbExtractor extractor({.features = 300});
  extractor.extract(image.view());
  extractor.set_features(100);
  const Features fewer = extractor.extract(image.view());
  EXPECT_LE(fewer.size(), 100U);
  EXPECT_TRUE(same(fewer, OrbExtractor({.features = 100}).extract(image.view())));
  EXPECT_THROW(extractor.set_features(0), Error);
}

TEST(Orb, DoesNotDependOnThePreviousImage) {
  const GrayImage first = blocks(300, 200, 5), second = blocks(260, 210, 6);
  OrbExtractor extractor({});
  extractor.extract(first.view());
  EXPECT_TRUE(same(extractor.extract(second.view()), OrbExtractor({}).extract(second.view())));
}

}  // namespace
}  // namespace rastro
