// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/shown_alike.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>

namespace rastro {
namespace {

/// Dark on the left, this much brighter from x = 10 on.
GrayImage edge_of(int height) {
  GrayImage image(20, 20);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 20; ++x) image.at(x, y) = static_cast<std::uint8_t>(x < 10 ? 40 : 40 + height);
  return image;
}

TEST(ShownAlike, NoiseIsNoChange) {
  const GrayImage here = edge_of(0);
  for (const auto& [intensity, is_alike] : {std::pair{40, true}, {52, true}, {54, false}, {28, true}, {26, false}}) {
    GrayImage other(20, 20);
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 20; ++x) other.at(x, y) = static_cast<std::uint8_t>(intensity);
    EXPECT_EQ(is_shown_alike(here.view(), 5, 5, other.view(), {5.4, 5.6}, {}), is_alike) << intensity << ": 3 * 4.2";
  }
}

TEST(ShownAlike, AnEdgeMayBeAPixelAside) {
  const GrayImage image = edge_of(100);
  EXPECT_TRUE(is_shown_alike(image.view(), 10, 5, image.view(), {9.0, 5.0}, {}));
  EXPECT_FALSE(is_shown_alike(image.view(), 10, 5, image.view(), {6.0, 5.0}, {.position_variance = 0.1}));
  EXPECT_TRUE(is_shown_alike(image.view(), 10, 5, image.view(), {6.0, 5.0}, {.position_variance = 16.0}));
}

TEST(ShownAlike, BrightnessMayChange) {
  const GrayImage here = edge_of(100), brighter = edge_of(200);
  const ShownAlikeOptions change{.gain = 2.0, .offset = -40.0};
  EXPECT_TRUE(is_shown_alike(here.view(), 15, 5, brighter.view(), {15.0, 5.0}, change));
  EXPECT_FALSE(is_shown_alike(here.view(), 15, 5, brighter.view(), {15.0, 5.0}, {}));
  EXPECT_TRUE(is_shown_alike(here.view(), 15, 5, edge_of(215).view(), {15.0, 5.0}, {.gain = 3.0})) << "clipped";
}

}  // namespace
}  // namespace rastro
