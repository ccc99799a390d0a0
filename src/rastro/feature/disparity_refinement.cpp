// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/disparity_refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace rastro {
namespace {

constexpr float scale = 8.0F;  ///< Of differences and gradients: sums over the largest window fit 32 bits.
constexpr int most_reach = 7;

/// What a window sums, of the pixels that have a disparity. Differences are left minus right.
enum Sum : std::uint8_t {
  count,
  gradient,
  difference,
  gradient_squared,
  product,
  difference_squared,
  left,
  left_squared
};
constexpr std::size_t sum_kinds = 8;
using Sums = std::array<std::vector<std::int32_t>, sum_kinds>;

/// Of one row; all 0 where there is no disparity.
struct Row {
  std::vector<std::int16_t> known, gradient, difference, left;
};

Row row_of(GrayView left_image, GrayView right_image, const Image<float>& disparity, int y) {
  const int width = left_image.width;
  const auto size = static_cast<std::size_t>(width);
  Row row{std::vector<std::int16_t>(size), std::vector<std::int16_t>(size), std::vector<std::int16_t>(size),
          std::vector<std::int16_t>(size)};
  const std::uint8_t *left = left_image.row(y), *right = right_image.row(y);
  for (int x = 1; x + 1 < width; ++x) {
    const float at = static_cast<float>(x) - disparity.at(x, y);
    if (disparity.at(x, y) <= 0.0F || at < 1.0F) continue;
    const int i = static_cast<int>(at);
    if (i + 2 >= width) continue;
    const float part = at - static_cast<float>(i);
    const float value = static_cast<float>(right[i]) + part * static_cast<float>(right[i + 1] - right[i]);
    const float slope = (1.0F - part) * static_cast<float>(right[i + 1] - right[i - 1]) +
                        part * static_cast<float>(right[i + 2] - right[i]);
    const auto k = static_cast<std::size_t>(x);
    row.known[k] = 1;
    row.left[k] = static_cast<std::int16_t>(left[x] - 128);
    row.difference[k] = static_cast<std::int16_t>(std::lround(scale * (static_cast<float>(left[x]) - value)));
    // The mean of both images: its noise is smaller.
    row.gradient[k] =
        static_cast<std::int16_t>(std::lround(0.25F * scale * (slope + static_cast<float>(left[x + 1] - left[x - 1]))));
  }
  return row;
}

/// Adds a row to the sums of its columns, or takes it away.
void add(const Row& row, int sign, Sums& columns) {
  const auto each = [&](Sum sum, const auto& value) {
    std::int32_t* to = columns[sum].data();
    for (std::size_t x = 0; x < row.known.size(); ++x) to[x] += sign * value(x);
  };
  const std::int16_t *g = row.gradient.data(), *d = row.difference.data(), *l = row.left.data();
  each(count, [&](std::size_t x) { return std::int32_t{row.known[x]}; });
  each(gradient, [&](std::size_t x) { return std::int32_t{g[x]}; });
  each(difference, [&](std::size_t x) { return std::int32_t{d[x]}; });
  each(gradient_squared, [&](std::size_t x) { return std::int32_t{g[x]} * g[x]; });
  each(product, [&](std::size_t x) { return std::int32_t{g[x]} * d[x]; });
  each(difference_squared, [&](std::size_t x) { return std::int32_t{d[x]} * d[x]; });
  each(left, [&](std::size_t x) { return std::int32_t{l[x]}; });
  each(left_squared, [&](std::size_t x) { return std::int32_t{l[x]} * l[x]; });
}

/// Sums of windows along the row, from those of the columns.
void slide(const Sums& columns, int reach, Sums& windows) {
  const auto width = static_cast<int>(columns[count].size());
  for (std::size_t kind = 0; kind < sum_kinds; ++kind) {
    const std::int32_t* from = columns[kind].data();
    std::int32_t sum = 0;
    for (int x = 0; x < std::min(reach, width); ++x) sum += from[x];
    for (int x = 0; x < width; ++x) {
      if (x + reach < width) sum += from[x + reach];
      if (x - reach - 1 >= 0) sum -= from[x - reach - 1];
      windows[kind][static_cast<std::size_t>(x)] = sum;
    }
  }
}

/// 0: the window does not fit, or has too few pixels with a disparity.
float refined(float disparity, const Sums& windows, std::size_t x, const DisparityRefinementOptions& options,
              int least_count) {
  const std::int32_t number = windows[count][x];
  if (disparity <= 0.0F || number < least_count) return 0.0F;
  const float n = static_cast<float>(number), each = 1.0F / n, unscaled = 1.0F / (scale * scale);
  const auto mean = [&](Sum sum) { return each * static_cast<float>(windows[sum][x]); };
  const float g = mean(gradient), d = mean(difference), l = mean(left);
  const float texture = unscaled * (mean(gradient_squared) - g * g);
  const float slope = unscaled * (mean(product) - g * d);
  const float of_difference = unscaled * (mean(difference_squared) - d * d), of_left = mean(left_squared) - l * l;
  // After the step the difference is smaller by what it explains.
  const float left_over = of_difference - slope * slope / (texture + static_cast<float>(options.least_texture));
  if (left_over > static_cast<float>(options.most_difference) * of_left + static_cast<float>(options.noise_variance))
    return 0.0F;
  const auto most = static_cast<float>(options.most_step_px);
  const float step = -slope / (texture + static_cast<float>(options.least_texture));
  return std::max(0.0F, disparity + std::clamp(step, -most, most));
}

void iterate(GrayView left_image, GrayView right_image, const DisparityRefinementOptions& options,
             Image<float>& disparity) {
  const int height = left_image.height, reach = std::clamp(options.reach_px, 1, most_reach);
  const int least_count = (2 * reach + 1) * (2 * reach + 1) / 3;
  const auto width = static_cast<std::size_t>(left_image.width);
  Sums columns, windows;
  for (std::size_t kind = 0; kind < sum_kinds; ++kind) columns[kind].resize(width), windows[kind].resize(width);
  std::vector<Row> rows;  // those of the window, in turn: read before the disparities change
  const auto slots = static_cast<std::size_t>(2 * reach + 1);
  rows.resize(slots);
  const auto slot = [&](int y) -> Row& { return rows[static_cast<std::size_t>(y) % slots]; };
  const auto enter = [&](int y) {
    slot(y) = row_of(left_image, right_image, disparity, y);
    add(slot(y), 1, columns);
  };
  for (int y = 0; y < std::min(reach, height); ++y) enter(y);
  for (int y = 0; y < height; ++y) {
    if (y - reach - 1 >= 0) add(slot(y - reach - 1), -1, columns);
    if (y + reach < height) enter(y + reach);
    slide(columns, reach, windows);
    float* row = disparity.row(y);
    for (std::size_t x = 0; x < width; ++x) row[x] = refined(row[x], windows, x, options, least_count);
  }
}

}  // namespace

void refine_disparity(GrayView left, GrayView right, const DisparityRefinementOptions& options,
                      Image<float>& disparity) {
  for (int i = 0; i < options.iterations; ++i) iterate(left, right, options, disparity);
}

}  // namespace rastro
