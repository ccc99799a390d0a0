// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/klt_patch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "rastro/image/image_testing.h"
#include "rastro/track/klt.h"

namespace rastro {
namespace {

constexpr int row_length = KltPatch::row_length;

const PaddedImage& wave() {
  static const PaddedImage image = testing::padded(testing::wave_image(90, 80, 0.0, 0.0), klt_padding);
  return image;
}
const PaddedImage& moved_wave() {
  static const PaddedImage image = testing::padded(testing::wave_image(90, 80, 0.7, -0.4), klt_padding);
  return image;
}

KltWindow window_at(const PaddedImage& image, int x, int y, double fraction_x, double fraction_y) {
  return {image.row(y) + x, image.stride(), static_cast<std::int16_t>(std::lround(32768.0 * fraction_x)),
          static_cast<std::int16_t>(std::lround(32768.0 * fraction_y))};
}

double bilinear(const PaddedImage& image, double x, double y) {
  const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
  const double fx = x - left, fy = y - top;
  return (1.0 - fy) * ((1.0 - fx) * image.row(top)[left] + fx * image.row(top)[left + 1]) +
         fy * ((1.0 - fx) * image.row(top + 1)[left] + fx * image.row(top + 1)[left + 1]);
}

/// Sobel over interpolated pixels, gray levels a pixel.
Eigen::Vector2d gradient(const PaddedImage& image, double x, double y) {
  const auto at = [&](int dx, int dy) { return bilinear(image, x + dx, y + dy); };
  const auto across = [&](int dy) { return at(1, dy) - at(-1, dy); };
  const auto down = [&](int dx) { return at(dx, 1) - at(dx, -1); };
  return {(across(-1) + 2.0 * across(0) + across(1)) / 8.0, (down(-1) + 2.0 * down(0) + down(1)) / 8.0};
}

struct Cut {
  int x, y;
  double fraction_x, fraction_y;
  int size;
};
const Cut cuts[] = {{20, 30, 0.0, 0.0, 21}, {11, 40, 0.5, 0.25, 21}, {50, 20, 0.93, 0.07, 9}, {30, 25, 0.3, 0.99, 31}};

const KltKernels* const every_kernel[] = {&klt_kernels_plain(), &klt_kernels_avx2()};

TEST(KltPatch, HoldsInterpolatedIntensitiesAndTheirSobelGradients) {
  for (const KltKernels* kernels : every_kernel) {
    for (const Cut& cut : cuts) {
      KltPatch patch;
      kernels->cut(window_at(wave(), cut.x, cut.y, cut.fraction_x, cut.fraction_y), cut.size, patch);
      EXPECT_EQ(patch.size, cut.size);
      for (int y = 0; y < cut.size; ++y) {
        for (int x = 0; x < cut.size; ++x) {
          const double px = cut.x + x + cut.fraction_x, py = cut.y + y + cut.fraction_y;
          const int at = y * row_length + x;
          const Eigen::Vector2d expected = gradient(wave(), px, py);
          ASSERT_NEAR(patch.intensity[at], 32.0 * bilinear(wave(), px, py), 1.5) << x << ' ' << y;
          // Sums are rounded to the nearest, their differences down.
          ASSERT_NEAR(patch.gradient_x[at], 16.0 * expected.x(), 2.0) << x << ' ' << y;
          ASSERT_NEAR(patch.gradient_y[at], 16.0 * expected.y(), 2.0) << x << ' ' << y;
        }
      }
    }
  }
}

TEST(KltPatch, NothingBehindTheWindowTakesPart) {
  for (const KltKernels* kernels : every_kernel) {
    for (const Cut& cut : cuts) {
      KltPatch patch;
      std::fill(std::begin(patch.gradient_x), std::end(patch.gradient_x), std::int16_t{77});
      std::fill(std::begin(patch.gradient_y), std::end(patch.gradient_y), std::int16_t{77});
      kernels->cut(window_at(wave(), cut.x, cut.y, cut.fraction_x, cut.fraction_y), cut.size, patch);
      for (int x = 0; x < row_length; ++x) EXPECT_EQ(patch.ones[x], x < cut.size ? 1 : 0) << x;
      for (int y = 0; y < cut.size; ++y)
        for (int x = cut.size; x < row_length; ++x) {
          ASSERT_EQ(patch.gradient_x[y * row_length + x], 0) << x;
          ASSERT_EQ(patch.gradient_y[y * row_length + x], 0) << x;
        }
    }
  }
}

/// Over the window of a patch.
template <typename Value>
std::int64_t sum_over(const KltPatch& patch, const Value& value) {
  std::int64_t sum = 0;
  for (int y = 0; y < patch.size; ++y)
    for (int at = y * row_length; at < y * row_length + patch.size; ++at) sum += value(at);
  return sum;
}

TEST(KltPatch, SumsAreThoseOfItsPixelsOneByOne) {
  for (const KltKernels* kernels : every_kernel) {
    for (const Cut& cut : cuts) {
      // What the current window holds is cut there: both are interpolated alike.
      KltPatch patch, now;
      const KltWindow current = window_at(moved_wave(), cut.x, cut.y, cut.fraction_y, cut.fraction_x);
      kernels->cut(window_at(wave(), cut.x, cut.y, cut.fraction_x, cut.fraction_y), cut.size, patch);
      kernels->cut(current, cut.size, now);
      const auto gx = [&](int at) { return std::int64_t{patch.gradient_x[at]}; };
      const auto gy = [&](int at) { return std::int64_t{patch.gradient_y[at]}; };
      const auto off = [&](int at) { return std::int64_t{now.intensity[at]} - patch.intensity[at]; };
      EXPECT_EQ(patch.xx, sum_over(patch, [&](int at) { return gx(at) * gx(at); }));
      EXPECT_EQ(patch.xy, sum_over(patch, [&](int at) { return gx(at) * gy(at); }));
      EXPECT_EQ(patch.yy, sum_over(patch, [&](int at) { return gy(at) * gy(at); }));
      EXPECT_EQ(patch.x, sum_over(patch, gx));
      EXPECT_EQ(patch.y, sum_over(patch, gy));
      const KltMismatch mismatch = kernels->mismatch(current, patch);
      EXPECT_EQ(mismatch.ex, sum_over(patch, [&](int at) { return off(at) * gx(at); }));
      EXPECT_EQ(mismatch.ey, sum_over(patch, [&](int at) { return off(at) * gy(at); }));
      EXPECT_EQ(mismatch.e, sum_over(patch, off));
      const KltResidual residual = kernels->residual(current, patch);
      const auto eighths = [&](int at) { return off(at) >> 2; };
      const auto value = [&](int at) { return std::int64_t{patch.intensity[at]} >> 2; };
      EXPECT_EQ(residual.squared_difference, sum_over(patch, [&](int at) { return eighths(at) * eighths(at); }));
      EXPECT_EQ(residual.difference, sum_over(patch, eighths));
      EXPECT_EQ(residual.squared_patch, sum_over(patch, [&](int at) { return value(at) * value(at); }));
      EXPECT_EQ(residual.patch, sum_over(patch, value));
    }
  }
}

TEST(KltRotation, IsTheBilinearValueAtTheRotatedPositionWithEdgesRepeated) {
  constexpr int side = 38;
  std::vector<std::uint8_t> pixels(side * side + 8);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      pixels[static_cast<std::size_t>(y * side + x)] = static_cast<std::uint8_t>(5 * x + 2 * y);
  const auto fixed = [](double value) { return static_cast<std::int32_t>(std::lround(65536.0 * value)); };
  const double x0 = -3.0, y0 = 6.5, across_x = 1.3, across_y = -0.4, down_x = 0.4, down_y = 1.1;
  const KltRotation rotation{pixels.data(),   side,          fixed(x0),     fixed(y0), fixed(across_x),
                             fixed(across_y), fixed(down_x), fixed(down_y), 30};
  for (const KltKernels* kernels : every_kernel) {
    std::vector<std::uint8_t> rotated(KltRotation::row_length * 40);
    kernels->rotate(rotation, rotated.data());
    for (int y = 0; y < rotation.rows; ++y) {
      for (int x = 0; x < rotation.rows; ++x) {
        const double px = std::clamp(x0 + x * across_x + y * down_x, 0.0, side - 1.0);
        const double py = std::clamp(y0 + x * across_y + y * down_y, 0.0, side - 1.0);
        // Of a plane the bilinear value is the plane's.
        ASSERT_NEAR(rotated[static_cast<std::size_t>(y * KltRotation::row_length + x)], 5.0 * px + 2.0 * py, 0.6)
            << x << ' ' << y;
      }
    }
  }
}

Pyramid one_level(const GrayImage& image) {
  Pyramid pyramid;
  pyramid.build(image.view(), 1, klt_padding);
  return pyramid;
}

/// 128 + gain * (image - 128).
GrayImage with_contrast(const GrayImage& image, double gain) {
  GrayImage result(image.width(), image.height());
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      result.at(x, y) = static_cast<std::uint8_t>(std::lround(128.0 + gain * (image.at(x, y) - 128.0)));
  return result;
}

TEST(KltReference, TheResidualOfAnotherContrastIsItsDifferenceSquared) {
  const GrayImage image = testing::wave_image(120, 100, 0.0, 0.0);
  KltReference reference;
  reference.keep(one_level(image), {60.0F, 50.0F}, 21);
  for (const double gain : {1.0, 0.7, 0.5, 1.1})
    EXPECT_NEAR(reference.residual_ratio(one_level(with_contrast(image, gain)), {60.0F, 50.0F}),
                (gain - 1.0) * (gain - 1.0), 0.003)
        << gain;
  EXPECT_EQ(reference.residual_ratio(one_level(image), {-20.0F, 50.0F}), 1e9);
  EXPECT_EQ(KltReference().residual_ratio(one_level(image), {60.0F, 50.0F}), 1e9);
}

TEST(KltReference, IsFollowedNoFartherThanItsReach) {
  const Pyramid before = one_level(testing::wave_image(120, 100, 0.0, 0.0));
  KltReference reference;
  reference.keep(before, {60.0F, 50.0F}, 21);
  const Eigen::Vector2f guess(62.4F, 48.2F);  // 3 pixels away
  EXPECT_TRUE(reference.align(before, guess, 3.4, {}).followed);
  EXPECT_FALSE(reference.align(before, guess, 2.6, {}).followed);
}

TEST(Klt, TextureBelowTheLeastEigenvalueIsNotFollowed) {
  // Over a whole period the mean squared derivative of a sin(k x) is (a k)^2 / 2, and Sobel sees sin(k) for k.
  constexpr int period = 21;
  const double k = 2.0 * std::numbers::pi / period, amplitude = 40.0;
  GrayImage image(126, 105);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      image.at(x, y) =
          static_cast<std::uint8_t>(std::lround(128.0 + amplitude * std::sin(k * x) + amplitude * std::sin(k * y)));
  const Pyramid pyramid = one_level(image);
  const double eigenvalue = 0.5 * std::pow(amplitude * std::sin(k), 2);
  const std::vector<Eigen::Vector2f> points = {{63.0F, 52.0F}, {50.0F, 45.5F}};
  std::vector<KltResult> results(points.size());
  for (const double share : {0.97, 1.03}) {
    KltOptions options;
    options.window_px = period;
    options.min_eigenvalue = share * eigenvalue;
    klt_follow(pyramid, pyramid, points, points, options, nullptr, results);
    for (const KltResult& result : results) EXPECT_EQ(result.followed, share < 1.0) << share;
  }
}

TEST(Klt, FollowsWhatLeavesNoMoreThanTheLargestResidual) {
  const GrayImage image = testing::wave_image(120, 100, 0.0, 0.0);
  const Pyramid before = one_level(image), after = one_level(with_contrast(image, 0.6));
  std::vector<Eigen::Vector2f> points;
  for (float x = 20.0F; x < 100.0F; x += 8.0F) points.emplace_back(x, 0.7F * x + 5.0F);
  std::vector<KltResult> all(points.size()), limited(points.size());
  KltOptions options;
  options.max_residual_ratio = 10.0;
  options.backward_levels = 0;
  klt_follow(before, after, points, points, options, nullptr, all);
  for (const KltResult& result : all) EXPECT_TRUE(result.followed);
  const double limit = static_cast<double>(all[4].residual_ratio) + 1e-6;
  options.max_residual_ratio = limit;
  klt_follow(before, after, points, points, options, nullptr, limited);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_EQ(limited[i].followed, static_cast<double>(all[i].residual_ratio) <= limit) << i;
}

TEST(Klt, TrackingBackwardTellsWhatIsNotTheSame) {
  const Pyramid before = one_level(testing::noise_image(120, 100, 1)),
                after = one_level(testing::noise_image(120, 100, 2));
  std::vector<Eigen::Vector2f> points;
  for (float x = 20.0F; x < 100.0F; x += 2.0F) points.emplace_back(x, 0.7F * x + 5.0F);
  std::vector<KltResult> results(points.size());
  const auto followed = [&](const KltOptions& options) {
    klt_follow(before, after, points, points, options, nullptr, results);
    return std::count_if(results.begin(), results.end(), [](const KltResult& result) { return result.followed; });
  };
  KltOptions options;
  options.max_residual_ratio = 10.0;
  options.backward_levels = 0;
  const auto unchecked = followed(options);
  EXPECT_GT(unchecked, 10);
  options.backward_levels = 1;
  EXPECT_LT(followed(options), unchecked / 2);
  options.max_backward_px = 1e6;
  EXPECT_GT(followed(options), 9 * unchecked / 10);
}

}  // namespace
}  // namespace rastro
