// SPDX-License-Identifier: Apache-2.0
#include "rastro/image/equalize.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "rastro/image/image_testing.h"

namespace rastro {
namespace {

TEST(Equalized, IsWithinOneLevelOfOpenCv) {
  GrayImage image = testing::wave_image(90, 70, 0.3, 0.1);
  for (int y = 0; y < 70; ++y) {
    for (int x = 0; x < 90; ++x) image.at(x, y) = static_cast<std::uint8_t>(40 + image.at(x, y) / 8);
  }
  cv::Mat expected;
  cv::equalizeHist(cv::Mat(70, 90, CV_8U, image.row(0), static_cast<std::size_t>(image.stride())), expected);
  const GrayImage ours = equalized(image.view());
  for (int y = 0; y < 70; ++y) {
    for (int x = 0; x < 90; ++x) ASSERT_NEAR(ours.at(x, y), expected.at<std::uint8_t>(y, x), 1);
  }
}

TEST(Brightness, OfAFlatImageHasNoDeviation) {
  GrayImage flat(32, 16);
  for (int y = 0; y < 16; ++y) std::memset(flat.row(y), 77, 32);
  EXPECT_DOUBLE_EQ(brightness(flat.view()).mean, 77.0);
  EXPECT_DOUBLE_EQ(brightness(flat.view()).deviation, 0.0);
}

}  // namespace
}  // namespace rastro
