// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/occluder/occluder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "rastro/base/error.h"

namespace rastro {
namespace {

constexpr int width = 240, height = 160;

GrayImage plain_image() {
  GrayImage image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.at(x, y) = static_cast<std::uint8_t>((x * 7 + y * 13) % 251);
  return image;
}

struct Drawn {
  GrayImage image = plain_image(), mask;
};

Drawn draw(Occluder& occluder, std::int64_t frame) {
  Drawn drawn;
  occluder.draw(frame, drawn.image, drawn.mask);
  return drawn;
}

bool equal(const GrayImage& a, const GrayImage& b) {
  for (int y = 0; y < a.height(); ++y)
    if (!std::equal(a.row(y), a.row(y) + a.width(), b.row(y))) return false;
  return a.width() == b.width() && a.height() == b.height();
}

int covered_pixels(const GrayImage& mask) {
  int count = 0;
  for (int y = 0; y < mask.height(); ++y)
    count += static_cast<int>(std::count(mask.row(y), mask.row(y) + mask.width(), 255));
  return count;
}

TEST(Occluder, DependsOnTheSeedAloneNotOnWhatWasDrawnBefore) {
  Occluder forward(width, height, {5}), alone(width, height, {5}), other(width, height, {6});
  bool differs = false;
  for (std::int64_t k = 0; k < 100; k += 3) {
    const Drawn drawn = draw(forward, k);
    if (k % 21 == 0) {
      const Drawn again = draw(alone, k);
      EXPECT_TRUE(equal(drawn.image, again.image) && equal(drawn.mask, again.mask)) << k;
      Occluder anew(width, height, {5});
      EXPECT_TRUE(equal(drawn.image, draw(anew, k).image)) << k;
    }
    differs = differs || !equal(drawn.image, draw(other, k).image);
  }
  EXPECT_TRUE(differs);
}

TEST(Occluder, MaskIsWhereTheImageChanged) {
  const GrayImage before = plain_image();
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Occluder occluder(width, height, {seed});
    int masked = 0, changed = 0;
    for (std::int64_t k = 0; k < 90; ++k) {
      const Drawn drawn = draw(occluder, k);
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          const bool is_changed = drawn.image.at(x, y) != before.at(x, y);
          const bool is_masked = drawn.mask.at(x, y) == 255;
          ASSERT_TRUE(is_masked || (drawn.mask.at(x, y) == 0 && !is_changed)) << k << ": " << x << " " << y;
          masked += is_masked;
          changed += is_changed;
        }
      }
    }
    ASSERT_GT(masked, 0);
    EXPECT_GT(changed, 0.96 * masked) << "a pixel may keep its intensity by chance or under the faint edge, but rarely";
  }
}

TEST(Occluder, LeavesTheFirstFramesAloneAndReturns) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Occluder occluder(width, height, {seed});
    for (std::int64_t k = 0; k < 8; ++k) EXPECT_EQ(covered_pixels(draw(occluder, k).mask), 0);
    int passes = 0;
    bool seen = false;
    for (std::int64_t k = 8; k < 200; ++k) {
      const bool sees = covered_pixels(draw(occluder, k).mask) > 0;
      passes += seen && !sees;
      seen = sees;
    }
    EXPECT_GE(passes, 3) << seed;
  }
}

TEST(Occluder, PointsAreOccludedForFourToTwelveFrames) {
  std::vector<int> spans;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Occluder occluder(width, height, {seed});
    std::vector<int> hidden(width, 0);
    for (std::int64_t k = 0; k < 160; ++k) {
      const GrayImage mask = draw(occluder, k).mask;
      // The row at two thirds of the height crosses the figure's body.
      for (int x = 0; x < width; ++x) {
        int& span = hidden[static_cast<std::size_t>(x)];
        if (mask.at(x, 2 * height / 3) != 0) {
          ++span;
        } else if (span > 0) {
          spans.push_back(span);
          span = 0;
        }
      }
    }
  }
  ASSERT_GT(spans.size(), 1000u);
  EXPECT_LE(*std::max_element(spans.begin(), spans.end()), 14);
  const auto usual = std::count_if(spans.begin(), spans.end(), [](int span) { return span >= 4 && span <= 12; });
  EXPECT_GT(static_cast<double>(usual), 0.9 * static_cast<double>(spans.size()));
}

TEST(Occluder, EveryColumnIsCrossed) {
  Occluder occluder(width, height, {3});
  std::vector<bool> crossed(width, false);
  const OccluderPass pass = occluder.pass_at(0);
  for (std::int64_t k = 0; k < pass.first + pass.frames; ++k) {
    const GrayImage mask = draw(occluder, k).mask;
    for (std::size_t x = 0; x < crossed.size(); ++x)
      crossed[x] = crossed[x] || mask.at(static_cast<int>(x), height / 2) != 0;
  }
  EXPECT_EQ(std::count(crossed.begin(), crossed.end(), true), width);
  EXPECT_EQ(covered_pixels(draw(occluder, pass.first + pass.frames).mask), 0);
}

TEST(Occluder, HasItsOwnTexture) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Occluder occluder(width, height, {seed});
    const OccluderPass pass = occluder.pass_at(0);
    Drawn drawn{GrayImage(width, height), {}};
    occluder.draw(pass.first + pass.frames / 2, drawn.image, drawn.mask);
    double sum = 0, squares = 0, count = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (drawn.mask.at(x, y) == 0 || drawn.image.at(x, y) < 20) continue;
        const double gray = drawn.image.at(x, y);
        sum += gray;
        squares += gray * gray;
        count += 1;
      }
    }
    ASSERT_GT(count, 1000);
    EXPECT_GT(std::sqrt(squares / count - sum * sum / count / count), 10.0) << seed;
  }
}

TEST(Occluder, RefusesTinyImages) { EXPECT_THROW(Occluder(16, 100, {}), Error); }

}  // namespace
}  // namespace rastro
