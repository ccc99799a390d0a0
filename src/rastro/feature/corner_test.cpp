// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/corner.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "rastro/base/simd_testing.h"
#include "rastro/feature/distance_grid.h"
#include "rastro/feature/min_eigenvalue.h"
#include "rastro/image/image_testing.h"

namespace rastro {
namespace {

using testing::padded;
using testing::with_plain_code;

GrayImage all_free(int width, int height) {
  GrayImage free(width, height);
  for (int y = 0; y < height; ++y) std::memset(free.row(y), 255, static_cast<std::size_t>(width));
  return free;
}

Image<float> scores_of(const PaddedImage& image) {
  Image<float> scores(image.width() + 32, image.height());
  MinEigenvalueScratch scratch;
  min_eigenvalues(image, 0, image.width(), 0, image.height(), scores.row(0), scores.stride(), scratch);
  return scores;
}

TEST(MinEigenvalues, AreOpenCvsUpToScale) {
  const GrayImage image = testing::wave_image(97, 61, 0.0, 0.0);
  cv::Mat expected;
  cv::cornerMinEigenVal(
      cv::Mat(61, 97, CV_8U, const_cast<std::uint8_t*>(image.row(0)), static_cast<std::size_t>(image.stride())),
      expected, 3, 3);
  const Image<float> scores = scores_of(padded(image, 48));
  double peak;
  cv::minMaxLoc(expected, nullptr, &peak);
  // OpenCV scales gradients by 1/(4 * 3 * 255); ours is twice the eigenvalue of unscaled sums.
  const double scale = 0.5 / (12.0 * 255.0 * 12.0 * 255.0);
  for (int y = 3; y < 58; ++y) {
    for (int x = 3; x < 94; ++x)
      ASSERT_NEAR(scores.at(x, y) * scale, expected.at<float>(y, x), 1e-4 * peak) << x << ' ' << y;
  }
}

TEST(MinEigenvalues, PlainAndFastCodeGiveTheSameBits) {
  const PaddedImage image = padded(testing::noise_image(103, 57, 21), 48);
  const Image<float> fast = scores_of(image);
  const Image<float> plain = with_plain_code([&] { return scores_of(image); });
  for (int y = 0; y < 57; ++y) ASSERT_EQ(std::memcmp(fast.row(y), plain.row(y), 103 * sizeof(float)), 0) << y;
}

TEST(CornerDetector, AgreesWithGoodFeaturesToTrack) {
  const GrayImage image = testing::wave_image(320, 240, 0.0, 0.0);
  // From three pixels off the edge on: closer, scores depend on how the image is extended beyond it.
  cv::Mat inside(240, 320, CV_8U, cv::Scalar(0));
  inside(cv::Rect(3, 3, 314, 234)) = 255;
  std::vector<cv::Point2f> expected;
  cv::goodFeaturesToTrack(
      cv::Mat(240, 320, CV_8U, const_cast<std::uint8_t*>(image.row(0)), static_cast<std::size_t>(image.stride())),
      expected, 60, 0.01, 15, inside);
  CornerDetector detector;
  const auto corners = detector.detect(padded(image, 48), all_free(320, 240).view(), 60, {0.01, 15.0, 3});
  ASSERT_EQ(corners.size(), expected.size());
  int same = 0;
  for (const Corner& corner : corners) {
    for (const auto& other : expected)
      same += std::abs(other.x - corner.x) + std::abs(other.y - corner.y) < 0.5 ? 1 : 0;
  }
  // Nearly equal scores may swap places, after which the greedy choice differs nearby.
  EXPECT_GE(same, 58);
}

TEST(CornerDetector, KeepsDistanceMaskBorderAndOrder) {
  const GrayImage image = testing::noise_image(200, 150, 4);
  GrayImage free = all_free(200, 150);
  for (int y = 0; y < 150; ++y) std::memset(free.row(y), 0, 80);
  CornerDetector detector;
  const auto corners = detector.detect(padded(image, 48), free.view(), 1000, {0.01, 12.0, 9});
  ASSERT_GT(corners.size(), 20U);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    EXPECT_GE(corners[i].x, 80);
    EXPECT_GE(corners[i].y, 9);
    EXPECT_LT(corners[i].y, 141);
    EXPECT_LT(corners[i].x, 191);
    EXPECT_LE(corners[i].score, corners[i > 0 ? i - 1 : i].score);
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_GE(std::hypot(corners[i].x - corners[j].x, corners[i].y - corners[j].y), 12.0);
  }
}

TEST(CornerDetector, SkippedTilesChangeNothing) {
  // With all but a region masked, the corners in the region are those of the full search restricted to it.
  const PaddedImage image = padded(testing::noise_image(300, 200, 8), 48);
  GrayImage spot(300, 200);
  for (int y = 70; y < 120; ++y) std::memset(spot.row(y) + 100, 255, 60);
  CornerDetector detector;
  const auto in_spot = detector.detect(image, spot.view(), 10000, {1e-6, 0.0, 1});
  auto all = detector.detect(image, all_free(300, 200).view(), 1000000, {1e-6, 0.0, 1});
  std::erase_if(all, [&](const Corner& c) { return spot.at(c.x, c.y) == 0; });
  ASSERT_EQ(in_spot.size(), all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(in_spot[i].x, all[i].x);
    EXPECT_EQ(in_spot[i].y, all[i].y);
  }
}

TEST(CornerDetector, AnyPoolGivesTheSameCorners) {
  const PaddedImage image = padded(testing::noise_image(301, 211, 12), 48);
  const GrayImage free = all_free(301, 211);
  CornerDetector detector;
  TaskPool pool(4);
  const auto alone = detector.detect(image, free.view(), 100, {});
  const auto pooled = detector.detect(image, free.view(), 100, {}, &pool);
  ASSERT_EQ(alone.size(), pooled.size());
  for (std::size_t i = 0; i < alone.size(); ++i) EXPECT_TRUE(alone[i].x == pooled[i].x && alone[i].y == pooled[i].y);
}

TEST(CornerDetector, FindsNothingInABlankOrTinyImage) {
  CornerDetector detector;
  EXPECT_TRUE(detector.detect(padded(GrayImage(64, 64), 48), all_free(64, 64).view(), 10, {}).empty());
  EXPECT_TRUE(detector.detect(padded(testing::noise_image(2, 2, 1), 48), all_free(2, 2).view(), 10, {}).empty());
}

TEST(DistanceGrid, AgreesWithBruteForce) {
  Random random(6);
  DistanceGrid grid(100, 80, 7.5);
  std::vector<std::pair<float, float>> kept;
  for (int i = 0; i < 500; ++i) {
    const auto x = static_cast<float>(random.uniform(0, 100)), y = static_cast<float>(random.uniform(0, 80));
    bool far = true;
    for (const auto& [px, py] : kept) far = far && (px - x) * (px - x) + (py - y) * (py - y) >= 7.5F * 7.5F;
    ASSERT_EQ(grid.add_if_far(x, y), far);
    if (far) kept.emplace_back(x, y);
  }
}

}  // namespace
}  // namespace rastro
