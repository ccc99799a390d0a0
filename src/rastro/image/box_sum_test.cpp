// SPDX-License-Identifier: Apache-2.0
#include "rastro/image/box_sum.h"

#include <gtest/gtest.h>

#include "rastro/base/simd_testing.h"
#include "rastro/image/image_testing.h"

namespace rastro {
namespace {

TEST(BoxSums, EqualBruteForceInPlainAndFastCode) {
  const PaddedImage image = testing::padded(testing::noise_image(67, 41, 3), 48);
  for (const int radius : {0, 1, 4, 7}) {
    Image<std::uint16_t> fast, plain;
    box_sums(image, radius, fast);
    testing::with_plain_code([&] { box_sums(image, radius, plain); });
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        int sum = 0;
        for (int dy = -radius; dy <= radius; ++dy) {
          for (int dx = -radius; dx <= radius; ++dx) sum += image.row(y + dy)[x + dx];
        }
        ASSERT_EQ(fast.at(x, y), sum) << radius << ' ' << x << ' ' << y;
        ASSERT_EQ(plain.at(x, y), sum) << radius << ' ' << x << ' ' << y;
      }
    }
  }
}

TEST(BoxSums, BrightestImageDoesNotOverflow) {
  GrayImage white(40, 40);
  for (int y = 0; y < 40; ++y) std::memset(white.row(y), 255, 40);
  Image<std::uint16_t> sums;
  box_sums(testing::padded(white, 48), 7, sums);
  EXPECT_EQ(sums.at(20, 20), 15 * 15 * 255);
}

}  // namespace
}  // namespace rastro
