// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/brief.h"

#include "rastro/base/simd.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "rastro/base/simd_testing.h"
#include "rastro/feature/hamming.h"
#include "rastro/image/box_sum.h"
#include "rastro/image/image_testing.h"

namespace rastro {
namespace {

Image<std::uint16_t> smooth(const GrayImage& image) {
  Image<std::uint16_t> sums;
  box_sums(testing::padded(image, 48), 4, sums);
  return sums;
}

/// `image` rotated by `angle` about its center and magnified by `scale`.
GrayImage rotated(const GrayImage& image, double angle, double scale) {
  GrayImage out(image.width(), image.height());
  const int cx = image.width() / 2, cy = image.height() / 2;
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const double dx = (x - cx) / scale, dy = (y - cy) / scale;
      const long sx = std::lround(cx + std::cos(angle) * dx + std::sin(angle) * dy);
      const long sy = std::lround(cy - std::sin(angle) * dx + std::cos(angle) * dy);
      if (sx >= 0 && sy >= 0 && sx < image.width() && sy < image.height()) {
        out.at(x, y) = image.at(static_cast<int>(sx), static_cast<int>(sy));
      }
    }
  }
  return out;
}

TEST(Brief, SamePatternForSameSeedOnly) {
  const auto sums = smooth(testing::wave_image(120, 120, 0, 0));
  EXPECT_EQ(Brief(48, 7).describe(sums, 60, 60), Brief(48, 7).describe(sums, 60, 60));
  EXPECT_FALSE(Brief(48, 7).describe(sums, 60, 60) == Brief(48, 8).describe(sums, 60, 60));
  EXPECT_EQ(Brief(48, 1).describe(sums, 60, 60), Brief(48, 1).describe(sums, 60.4F, 59.6F)) << "the same pixel";
}

/// BRIEF as published, in the plainest form: ends drawn from the Gaussian, rotated and scaled; each is the sum of a box
/// of pixels around it, or around the image's edge if it lies outside; boxes over the edge see it mirrored.
Descriptor plain_brief(const GrayImage& image, int x, int y, int patch_px, std::uint64_t seed, double angle_rad,
                       double scale) {
  Random random(seed);
  const auto draw = [&] {
    return static_cast<float>(std::clamp(patch_px / 5.0 * random.normal(), -patch_px / 2.0, patch_px / 2.0));
  };
  const auto mirrored = [](int at, int size) { return at < 0 ? -at : (at >= size ? 2 * (size - 1) - at : at); };
  const auto pixel = [&](int px, int py) {
    return int{image.at(mirrored(px, image.width()), mirrored(py, image.height()))};
  };
  const auto smoothed_at = [&](const std::array<double, 2>& end) {
    const double c = scale * std::cos(angle_rad), s = scale * std::sin(angle_rad);
    const int at_x = std::clamp(x + static_cast<int>(std::lround(c * end[0] - s * end[1])), 0, image.width() - 1);
    const int at_y = std::clamp(y + static_cast<int>(std::lround(s * end[0] + c * end[1])), 0, image.height() - 1);
    int sum = 0;
    for (int dy = -4; dy <= 4; ++dy) {
      for (int dx = -4; dx <= 4; ++dx) sum += pixel(at_x + dx, at_y + dy);
    }
    return sum;
  };
  Descriptor descriptor;
  for (std::size_t bit = 0; bit < 256;) {
    std::array<double, 2> a{}, b{};
    for (double* value : {&a[0], &a[1], &b[0], &b[1]}) *value = draw();
    if (std::lround(a[0]) == std::lround(b[0]) && std::lround(a[1]) == std::lround(b[1])) continue;
    if (smoothed_at(a) < smoothed_at(b)) descriptor.words[bit / 64] |= std::uint64_t{1} << (bit % 64);
    ++bit;
  }
  return descriptor;
}

TEST(Brief, EveryBitIsThatOfThePublicationsPlainTest) {
  const GrayImage image = testing::noise_image(150, 130, 11);
  const auto sums = smooth(image);
  constexpr double step = 2.0 * std::numbers::pi / 32;
  for (const int patch_px : {32, 48}) {
    const Brief brief(patch_px, 5);
    for (const auto& [x, y] : {std::pair{75, 65}, {60, 70}, {3, 8}, {149, 129}}) {
      EXPECT_EQ(brief.describe(sums, static_cast<float>(x), static_cast<float>(y)),
                plain_brief(image, x, y, patch_px, 5, 0.0, 1.0));
      for (const int step_count : {0, 1, 7, 16, 31}) {
        for (const double scale : Brief::scales())
          EXPECT_EQ(brief.describe(sums, static_cast<float>(x), static_cast<float>(y), (step_count + 0.4) * step,
                                   1.04 * scale),
                    plain_brief(image, x, y, patch_px, 5, step_count * step, scale))
              << x << ' ' << y << " rotation step " << step_count << " scale " << scale;
      }
    }
  }
}

TEST(Brief, TheBitsNeverChange) {
  // Maps and vocabularies store such bits: a compiler or machine that draws another pattern cannot read them.
  const auto sums = smooth(testing::noise_image(120, 120, 3));
  const Descriptor upright = Brief(48, 1).describe(sums, 60, 60);
  const Descriptor steered = Brief(48, 1).describe(sums, 60, 60, 1.0, 1.25);
  const std::array<std::uint64_t, 4> upright_words = {17589584012122676296U, 14389004723986540444U,
                                                      2237958365324514129U, 12565642954913282700U};
  const std::array<std::uint64_t, 4> steered_words = {2383329685560442602U, 5748953262042473857U, 11293931006511045646U,
                                                      5034026392521128477U};
  EXPECT_EQ(upright.words, upright_words);
  EXPECT_EQ(steered.words, steered_words);
}

TEST(Brief, MatchesUnderAShiftAndDistinguishesPoints) {
  const Brief brief(48, 1);
  const auto here = smooth(testing::wave_image(200, 200, 0, 0)),
             shifted = smooth(testing::wave_image(200, 200, 11, -6));
  const auto descriptor = brief.describe(here, 100, 100);
  EXPECT_LE(hamming_distance(descriptor, brief.describe(shifted, 111, 94)), 8);
  EXPECT_GE(hamming_distance(descriptor, brief.describe(here, 130, 120)), 60);
}

TEST(Brief, NearTheEdgePixelsAreTakenAtTheEdge) {
  const Brief brief(48, 1);
  const GrayImage image = testing::wave_image(100, 100, 0, 0);
  const auto sums = smooth(image);
  Image<std::uint16_t> larger(300, 300);
  for (int y = 0; y < 300; ++y) {
    for (int x = 0; x < 300; ++x) larger.at(x, y) = sums.at(std::clamp(x - 100, 0, 99), std::clamp(y - 100, 0, 99));
  }
  EXPECT_EQ(brief.describe(sums, 2, 97), brief.describe(larger, 102, 197));
}

TEST(Brief, SteeredAndScaledPatternsFollowRotationAndScale) {
  const Brief brief(48, 1);
  const GrayImage image = testing::wave_image(240, 240, 0, 0);
  const auto before = brief.describe(smooth(image), 120, 120);
  const double angle = std::numbers::pi / 4;
  const auto rotated_sums = smooth(rotated(image, angle, 1.0));
  EXPECT_LE(hamming_distance(before, brief.describe(rotated_sums, 120, 120, angle, 1.0)), 25);
  EXPECT_GE(hamming_distance(before, brief.describe(rotated_sums, 120, 120)), 60);
  const auto scaled_sums = smooth(rotated(image, 0.0, 1.5625));
  EXPECT_LT(hamming_distance(before, brief.describe(scaled_sums, 120, 120, 0.0, 1.5625)),
            hamming_distance(before, brief.describe(scaled_sums, 120, 120)));
}

TEST(Brief, EveryLevelOfSimdGivesTheSameBits) {
  const Brief brief(48, 1);
  const auto sums = smooth(testing::wave_image(160, 120, 0, 0));
  for (const double scale : Brief::scales()) {
    for (float position = 0.0F; position < 120.0F; position += 7.3F) {
      limit_simd_level(SimdLevel::plain);
      const Descriptor plain = brief.describe(sums, position, position, 0.1 * position, scale);
      limit_simd_level(SimdLevel::avx2);
      EXPECT_EQ(plain, brief.describe(sums, position, position, 0.1 * position, scale));
    }
  }
}

TEST(IntensityCentroid, PointsToTheBrightSide) {
  GrayImage image(61, 61);
  for (int y = 0; y < 61; ++y) {
    for (int x = 0; x < 61; ++x) image.at(x, y) = static_cast<std::uint8_t>(2 * x + 2 * y);
  }
  EXPECT_NEAR(intensity_centroid_angle(image.view(), 30, 30, 15), std::numbers::pi / 4, 1e-6);
}

TEST(Hamming, PlainAndFastCodeAreEqualToCountingBits) {
  Random random(3);
  std::vector<Descriptor> descriptors(77);
  for (auto& descriptor : descriptors) {
    for (auto& word : descriptor.words) word = random.next();
  }
  std::vector<std::uint16_t> fast(77), plain(77);
  hamming_distances(descriptors[5], descriptors, fast);
  testing::with_plain_code([&] { hamming_distances(descriptors[5], descriptors, plain); });
  for (std::size_t i = 0; i < 77; ++i) {
    int bits = 0;
    for (std::size_t bit = 0; bit < 256; ++bit) {
      bits += ((descriptors[i].words[bit / 64] ^ descriptors[5].words[bit / 64]) >> (bit % 64)) & 1U;
    }
    EXPECT_EQ(fast[i], bits);
    EXPECT_EQ(plain[i], bits);
  }
}

}  // namespace
}  // namespace rastro
