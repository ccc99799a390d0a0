// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/klt.h"

#include <Eigen/LU>

#include <gtest/gtest.h>

#include "rastro/base/simd_testing.h"
#include "rastro/image/image_testing.h"
#include "rastro/track/klt_patch.h"

namespace rastro {
namespace {

using testing::noise_image;
using testing::wave_image;

Pyramid pyramid_of(const GrayImage& image) {
  Pyramid pyramid;
  pyramid.build(image.view(), 4, klt_padding);
  return pyramid;
}

std::vector<Eigen::Vector2f> grid_points() {
  std::vector<Eigen::Vector2f> points;
  for (float y = 40; y < 200; y += 23) {
    for (float x = 40; x < 280; x += 23) points.emplace_back(x + 0.37F, y + 0.81F);
  }
  return points;
}

TEST(Klt, TracksAKnownShiftToAFewHundredthsOfAPixel) {
  for (const auto& [dx, dy] : {std::pair{0.0, 0.0}, {0.4, -0.3}, {5.25, 3.5}, {-14.6, 9.1}}) {
    const Pyramid a = pyramid_of(wave_image(320, 240, 0, 0)), b = pyramid_of(wave_image(320, 240, dx, dy));
    const auto points = grid_points();
    std::vector<KltResult> results(points.size());
    klt_follow(a, b, points, points, {}, nullptr, results);
    int followed = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!results[i].followed) continue;
      ++followed;
      EXPECT_NEAR(results[i].pixel.x() - points[i].x(), dx, 0.06);
      EXPECT_NEAR(results[i].pixel.y() - points[i].y(), dy, 0.06);
    }
    EXPECT_GE(followed, static_cast<int>(points.size()) * 9 / 10) << dx << ' ' << dy;
  }
}

TEST(Klt, AChangeOfBrightnessCausesNoMotion) {
  GrayImage brighter = wave_image(320, 240, 3.3, -2.2);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) brighter.at(x, y) = static_cast<std::uint8_t>(std::min(255, brighter.at(x, y) + 12));
  }
  const auto points = grid_points();
  std::vector<KltResult> results(points.size());
  klt_follow(pyramid_of(wave_image(320, 240, 0, 0)), pyramid_of(brighter), points, points, {}, nullptr, results);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (results[i].followed) {
      EXPECT_NEAR(results[i].pixel.x() - points[i].x(), 3.3, 0.08);
    }
  }
  EXPECT_GE(std::count_if(results.begin(), results.end(), [](const KltResult& r) { return r.followed; }),
            static_cast<std::ptrdiff_t>(points.size() * 9 / 10));
}

TEST(Klt, FlatAreasAndUnrelatedImagesAreNotTracked) {
  const auto points = grid_points();
  std::vector<KltResult> results(points.size());
  const Pyramid flat = pyramid_of(GrayImage(320, 240));
  klt_follow(flat, flat, points, points, {}, nullptr, results);
  for (const KltResult& result : results) EXPECT_FALSE(result.followed);
  klt_follow(pyramid_of(noise_image(320, 240, 1)), pyramid_of(noise_image(320, 240, 2)), points, points, {}, nullptr,
             results);
  EXPECT_LE(std::count_if(results.begin(), results.end(), [](const KltResult& r) { return r.followed; }), 4);
}

TEST(Klt, PointsOutsideOrNotANumberAreLost) {
  const Pyramid a = pyramid_of(wave_image(64, 64, 0, 0));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Eigen::Vector2f> points = {{-500, 3}, {3, 1e9F}, {nan, 5}, {0, 0}, {63, 63}};
  std::vector<KltResult> results(points.size());
  klt_follow(a, a, points, points, {}, nullptr, results);
  EXPECT_FALSE(results[0].followed);
  EXPECT_FALSE(results[1].followed);
  EXPECT_FALSE(results[2].followed);
}

TEST(Klt, PlainAndFastKernelsGiveTheSameSums) {
  Random random(11);
  const PaddedImage a = testing::padded(noise_image(90, 80, 3), klt_padding);
  const PaddedImage b = testing::padded(noise_image(90, 80, 4), klt_padding);
  for (int i = 0; i < 300; ++i) {
    const int size = 5 + 2 * static_cast<int>(random.below(14));
    const auto window = [&](const PaddedImage& image) {
      const int x = static_cast<int>(random.below(90)) - 15, y = static_cast<int>(random.below(80)) - 15;
      return KltWindow{image.row(y) + x, image.stride(), static_cast<std::int16_t>(random.below(32768)),
                       static_cast<std::int16_t>(random.below(32768))};
    };
    const KltWindow from = window(a), to = window(b);
    KltPatch plain, fast;
    klt_kernels_plain().cut(from, size, plain);
    klt_kernels_avx2().cut(from, size, fast);
    ASSERT_TRUE(plain.xx == fast.xx && plain.xy == fast.xy && plain.yy == fast.yy && plain.x == fast.x &&
                plain.y == fast.y);
    const KltMismatch m1 = klt_kernels_plain().mismatch(to, plain), m2 = klt_kernels_avx2().mismatch(to, fast);
    ASSERT_TRUE(m1.ex == m2.ex && m1.ey == m2.ey && m1.e == m2.e);
    const KltResidual r1 = klt_kernels_plain().residual(to, plain), r2 = klt_kernels_avx2().residual(to, fast);
    ASSERT_TRUE(r1.squared_difference == r2.squared_difference && r1.difference == r2.difference);
    ASSERT_TRUE(r1.squared_patch == r2.squared_patch && r1.patch == r2.patch);
  }
}

TEST(Klt, StrongestEdgesDoNotOverflow) {
  GrayImage checks(90, 80), inverse(90, 80);
  for (int y = 0; y < 80; ++y) {
    for (int x = 0; x < 90; ++x) {
      checks.at(x, y) = (x / 2) % 2 == 0 ? 255 : 0;
      inverse.at(x, y) = static_cast<std::uint8_t>(255 - checks.at(x, y));
    }
  }
  const PaddedImage a = testing::padded(checks, klt_padding), b = testing::padded(inverse, klt_padding);
  KltPatch plain, fast;
  const KltWindow from{a.row(20) + 20, a.stride(), 0, 0}, to{b.row(20) + 20, b.stride(), 0, 0};
  const KltWindow beside{b.row(20) + 21, b.stride(), 0, 0};
  klt_kernels_plain().cut(from, 31, plain);
  klt_kernels_avx2().cut(from, 31, fast);
  EXPECT_EQ(plain.xx, fast.xx);
  EXPECT_EQ(klt_kernels_plain().mismatch(beside, plain).ex, klt_kernels_avx2().mismatch(beside, fast).ex);
  EXPECT_EQ(klt_kernels_plain().residual(to, plain).squared_difference,
            klt_kernels_avx2().residual(to, fast).squared_difference);
}

TEST(KltReference, AlignsFromAFewPixelsAwayAndRejectsAnotherPatch) {
  const Pyramid before = pyramid_of(wave_image(320, 240, 0, 0)), after = pyramid_of(wave_image(320, 240, 7.3, -4.6));
  KltReference reference;
  EXPECT_TRUE(reference.empty());
  EXPECT_FALSE(reference.align(after, {100, 100}, 5.0, {}).followed);
  reference.keep(before, {120.3F, 90.7F}, 21);
  const KltResult found = reference.align(after, {129.0F, 85.0F}, 5.0, {});
  ASSERT_TRUE(found.followed);
  EXPECT_NEAR(found.pixel.x(), 127.6F, 0.05F);
  EXPECT_NEAR(found.pixel.y(), 86.1F, 0.05F);
  EXPECT_LT(reference.residual_ratio(after, {127.6F, 86.1F}), 0.02);
  EXPECT_GT(reference.residual_ratio(after, {227.6F, 176.1F}), 0.3);
}

TEST(KltReference, IsFoundRotatedAndScaledByAKnownAmount) {
  // The image b(p) = a(M^-1 p) shows a's center region rotated and scaled by M.
  Eigen::Matrix2f warp;
  warp << 1.08F, -0.46F, 0.46F, 1.08F;
  const GrayImage a = wave_image(320, 240, 0, 0);
  GrayImage b(320, 240);
  const Eigen::Vector2f middle(160.0F, 120.0F);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const Eigen::Vector2f from =
          warp.inverse() * (Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)) - middle) + middle;
      const int ix = std::clamp(static_cast<int>(std::floor(from.x())), 0, 318);
      const int iy = std::clamp(static_cast<int>(std::floor(from.y())), 0, 238);
      const float fx = from.x() - static_cast<float>(ix), fy = from.y() - static_cast<float>(iy);
      const float upper = (1 - fx) * a.at(ix, iy) + fx * a.at(ix + 1, iy);
      const float lower = (1 - fx) * a.at(ix, iy + 1) + fx * a.at(ix + 1, iy + 1);
      b.at(x, y) = static_cast<std::uint8_t>(std::clamp((1 - fy) * upper + fy * lower, 0.0F, 255.0F));
    }
  }
  const Pyramid before = pyramid_of(a), after = pyramid_of(b);
  for (const Eigen::Vector2f& position : {Eigen::Vector2f(160.0F, 120.0F), Eigen::Vector2f(140.3F, 131.8F)}) {
    KltReference reference;
    reference.keep(before, position, 21);
    const Eigen::Vector2f there = warp * (position - middle) + middle;
    const KltResult found = reference.align(after, there + Eigen::Vector2f(1.5F, -1.0F), 5.0, {}, warp);
    ASSERT_TRUE(found.followed);
    EXPECT_LT((found.pixel - there).norm(), 0.1F);
    EXPECT_GT(reference.residual_ratio(after, there), 4.0 * reference.residual_ratio(after, there, warp));
  }
}

TEST(Klt, PlainAndFastResamplingGiveTheSameBytes) {
  Random random(11);
  std::vector<std::uint8_t> pixels(38 * 38 + 64);
  for (auto& pixel : pixels) pixel = static_cast<std::uint8_t>(random.below(256));
  const auto within = [&](std::int32_t most) { return static_cast<std::int32_t>(random.below(2 * most)) - most; };
  for (int i = 0; i < 200; ++i) {
    const KltRotation rotation{pixels.data(),      38,
                               within(40 * 65536), within(40 * 65536),
                               within(2 * 65536),  within(2 * 65536),
                               within(131072),     within(131072),
                               24 + i % 11};
    std::vector<std::uint8_t> plain(KltRotation::row_length * 40), fast(plain.size());
    klt_kernels_plain().rotate(rotation, plain.data());
    klt_kernels_avx2().rotate(rotation, fast.data());
    for (int y = 0; y < rotation.rows; ++y) {
      for (int x = 0; x < rotation.rows; ++x) {
        ASSERT_EQ(plain[static_cast<std::size_t>(y * KltRotation::row_length + x)],
                  fast[static_cast<std::size_t>(y * KltRotation::row_length + x)]);
      }
    }
  }
}

TEST(Klt, AnyPoolGivesTheSameBytes) {
  const Pyramid a = pyramid_of(wave_image(320, 240, 0, 0)), b = pyramid_of(wave_image(320, 240, 4.2, 1.1));
  const auto points = grid_points();
  std::vector<KltResult> alone(points.size()), pooled(points.size()), plain(points.size());
  TaskPool pool(4);
  klt_follow(a, b, points, points, {}, nullptr, alone);
  klt_follow(a, b, points, points, {}, &pool, pooled);
  testing::with_plain_code([&] { klt_follow(a, b, points, points, {}, nullptr, plain); });
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(alone[i].pixel, pooled[i].pixel);
    EXPECT_EQ(alone[i].pixel, plain[i].pixel);
    EXPECT_EQ(alone[i].followed, plain[i].followed);
  }
}

}  // namespace
}  // namespace rastro
