// SPDX-License-Identifier: Apache-2.0
#include "rastro/image/pyramid.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "rastro/base/simd_testing.h"
#include "rastro/image/image_testing.h"

namespace rastro {
namespace {

using testing::noise_image;
using testing::with_plain_code;

bool equal(const PaddedImage& a, const PaddedImage& b) {
  if (a.width() != b.width() || a.height() != b.height()) return false;
  for (int y = -a.padding(); y < a.height() + a.padding(); ++y) {
    if (std::memcmp(a.row(y) - a.padding(), b.row(y) - b.padding(),
                    static_cast<std::size_t>(a.width()) + 2 * static_cast<std::size_t>(a.padding())) != 0)
      return false;
  }
  return true;
}

TEST(Pyramid, EqualsOpenCvsPyrDown) {
  for (const auto& [width, height] : {std::pair{64, 48}, {101, 77}, {40, 33}}) {
    GrayImage image = noise_image(width, height, 5);
    Pyramid pyramid;
    pyramid.build(image.view(), 2, 48);
    cv::Mat expected;
    cv::pyrDown(cv::Mat(height, width, CV_8U, image.row(0), static_cast<std::size_t>(image.stride())), expected);
    ASSERT_EQ(pyramid.level(1).width(), expected.cols);
    ASSERT_EQ(pyramid.level(1).height(), expected.rows);
    for (int y = 0; y < expected.rows; ++y) {
      for (int x = 0; x < expected.cols; ++x)
        ASSERT_EQ(pyramid.level(1).row(y)[x], expected.at<std::uint8_t>(y, x)) << x << ' ' << y;
    }
  }
}

TEST(Pyramid, PlainAndFastCodeAndAnyPoolGiveTheSameBytes) {
  const GrayImage image = noise_image(203, 131, 9);
  Pyramid fast, plain, pooled;
  TaskPool pool(3);
  fast.build(image.view(), 4, 48);
  with_plain_code([&] { plain.build(image.view(), 4, 48); });
  pooled.build(image.view(), 4, 48, &pool);
  for (int level = 0; level < 4; ++level) {
    EXPECT_TRUE(equal(fast.level(level), plain.level(level))) << level;
    EXPECT_TRUE(equal(fast.level(level), pooled.level(level))) << level;
  }
}

TEST(Pyramid, StopsBeforeLevelsGetTiny) {
  Pyramid pyramid;
  pyramid.build(noise_image(70, 40, 1).view(), 8, 48);
  EXPECT_EQ(pyramid.levels(), 3);
  pyramid.build(noise_image(1, 1, 1).view(), 8, 48);
  EXPECT_EQ(pyramid.levels(), 1);
}

TEST(PaddedImage, MirrorsAboutTheBorderPixel) {
  const PaddedImage image = testing::padded(noise_image(20, 16, 2), 8);
  for (int d = 1; d <= 8; ++d) {
    EXPECT_EQ(image.row(3)[-d], image.row(3)[d]);
    EXPECT_EQ(image.row(3)[19 + d], image.row(3)[19 - d]);
    EXPECT_EQ(image.row(-d)[5], image.row(d)[5]);
    EXPECT_EQ(image.row(15 + d)[-2], image.row(15 - d)[2]);
  }
}

}  // namespace
}  // namespace rastro
