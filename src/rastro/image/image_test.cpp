// SPDX-License-Identifier: Apache-2.0
#include "rastro/image/image.h"

#include <gtest/gtest.h>

#include "rastro/base/simd_testing.h"
#include "rastro/image/equalize.h"
#include "rastro/image/image_testing.h"
#include "rastro/image/pyramid.h"

namespace rastro {
namespace {

TEST(Image, RowsStartAtMultiplesOf64BytesAndPixelsAreZero) {
  for (const int width : {1, 63, 64, 65, 200}) {
    const Image<float> image(width, 3);
    EXPECT_GE(image.stride(), width);
    EXPECT_LT(image.stride(), width + 16) << "no more than what rounds it up";
    for (int y = 0; y < 3; ++y) {
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(image.row(y)) % 64, 0U);
      for (int x = 0; x < width; ++x) ASSERT_EQ(image.at(x, y), 0.0F);
    }
  }
}

TEST(Image, ACopyIsItsOwnAndAMovedOneIsEmpty) {
  GrayImage image = testing::noise_image(33, 7, 5);
  GrayImage copy = image;
  EXPECT_EQ(copy.at(32, 6), image.at(32, 6));
  copy.at(32, 6) = static_cast<std::uint8_t>(image.at(32, 6) + 1);
  EXPECT_NE(copy.at(32, 6), image.at(32, 6));
  const std::uint8_t kept = image.at(4, 5);
  const GrayImage moved = std::move(image);
  EXPECT_EQ(moved.at(4, 5), kept);
  copy = moved;
  EXPECT_EQ(copy.at(4, 5), kept);
  EXPECT_EQ(copy.width(), 33);
}

TEST(Image, EmptyWhereASideIsZero) {
  EXPECT_TRUE(GrayImage().empty());
  EXPECT_TRUE(GrayImage(0, 5).empty());
  EXPECT_TRUE(GrayImage(5, 0).empty());
  EXPECT_FALSE(GrayImage(1, 1).empty());
  EXPECT_TRUE(GrayView().empty());
  EXPECT_TRUE(GrayImage(0, 5).view().empty());
}

TEST(Image, AViewReadsAndWritesThePixelsOfTheImage) {
  GrayImage image(20, 10);
  const ImageView<std::uint8_t> view = image.view();
  view.at(19, 9) = 77;
  EXPECT_EQ(image.at(19, 9), 77);
  EXPECT_EQ(view.row(9)[19], 77);
  const GrayView same = view;
  EXPECT_EQ(same.at(19, 9), 77);
}

TEST(GrayFromColor, WeighsRedGreenAndBlueAsTheStandardSays) {
  ColorImage color;
  color.rgb = Image<std::uint8_t>(5 * 3, 2);
  const std::uint8_t pixels[5][3] = {{255, 255, 255}, {255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {10, 200, 77}};
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 5; ++x) std::copy_n(pixels[x], 3, color.rgb.row(y) + 3 * x);
  EXPECT_EQ(color.width(), 5);
  EXPECT_EQ(color.height(), 2);
  const GrayImage gray = gray_from_color(color);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 5; ++x) {
      const double expected = 0.299 * pixels[x][0] + 0.587 * pixels[x][1] + 0.114 * pixels[x][2];
      EXPECT_NEAR(gray.at(x, y), expected, 0.51) << x;
    }
  EXPECT_EQ(gray.at(0, 0), 255);
}

TEST(PaddedImage, IsTheMirrorImageWhateverItsSize) {
  for (const auto& [width, height, padding] :
       {std::tuple{20, 16, 19}, {20, 16, 8}, {7, 30, 5}, {30, 7, 6}, {9, 9, 0}}) {
    const PaddedImage image = testing::padded(testing::noise_image(width, height, 2), padding);
    const auto mirrored = [](int i, int size) { return i < 0 ? -i : i >= size ? 2 * (size - 1) - i : i; };
    for (int y = -std::min(padding, height - 1); y < height + std::min(padding, height - 1); ++y)
      for (int x = -padding; x < width + padding; ++x)
        ASSERT_EQ(image.row(y)[x], image.row(mirrored(y, height))[mirrored(x, width)]) << x << ' ' << y;
  }
}

TEST(PaddedImage, SmallerThanItsPaddingIsMirroredAsFarAsItGoesAndThenRepeated) {
  const PaddedImage image = testing::padded(testing::noise_image(3, 2, 2), 6);
  const int expected[] = {0, 0, 0, 1, 2, 1, 0, 1, 2, 1, 0, 0, 0, 0, 0};  // of columns -6 .. 8
  for (int x = -6; x <= 8; ++x) EXPECT_EQ(image.row(1)[x], image.row(1)[expected[x + 6]]) << x;
  const PaddedImage one = testing::padded(testing::noise_image(1, 1, 2), 3);
  for (int y = -3; y <= 3; ++y)
    for (int x = -3; x <= 3; ++x) EXPECT_EQ(one.row(y)[x], one.row(0)[0]);
}

TEST(PaddedImage, KeepsItsMemoryForTheSameSizeAlone) {
  PaddedImage image;
  image.reset(20, 10, 4);
  const std::uint8_t* before = image.row(0);
  image.row(3)[3] = 99;
  image.reset(20, 10, 4);
  EXPECT_EQ(image.row(0), before);
  EXPECT_EQ(image.row(3)[3], 99);
  for (const auto& [width, height, padding] : {std::tuple{21, 10, 4}, {20, 11, 4}, {20, 10, 5}}) {
    image.reset(width, height, padding);
    EXPECT_EQ(image.width(), width);
    EXPECT_EQ(image.height(), height);
    EXPECT_EQ(image.padding(), padding);
    EXPECT_EQ(image.view().width, width);
  }
}

TEST(Pyramid, WithLittlePaddingPlainAndFastCodeAgree) {
  const PaddedImage source = testing::padded(testing::noise_image(131, 77, 3), 4);
  PaddedImage fast, plain;
  halve(source, fast, nullptr);
  testing::with_plain_code([&] { halve(source, plain, nullptr); });
  EXPECT_EQ(fast.width(), 66);
  EXPECT_EQ(fast.height(), 39);
  for (int y = -4; y < fast.height() + 4; ++y)
    EXPECT_EQ(std::memcmp(fast.row(y) - 4, plain.row(y) - 4, static_cast<std::size_t>(fast.width() + 8)), 0) << y;
}

TEST(Brightness, IsMeanAndDeviationOfEveryFourthPixelOfEveryFourthRow) {
  const GrayImage image = testing::noise_image(14, 9, 6);
  std::vector<double> values;
  for (int y = 0; y < 9; y += 4)
    for (int x = 0; x < 14; x += 4) values.push_back(image.at(x, y));
  double mean = 0.0, squares = 0.0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  for (const double value : values) squares += (value - mean) * (value - mean) / static_cast<double>(values.size());
  EXPECT_NEAR(brightness(image.view()).mean, mean, 1e-9);
  EXPECT_NEAR(brightness(image.view()).deviation, std::sqrt(squares), 1e-9);
}

}  // namespace
}  // namespace rastro
