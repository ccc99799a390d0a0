// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/klt_patch.h"

#include <algorithm>

#include <cstring>

#include "rastro/base/simd.h"

namespace rastro {
namespace {

constexpr int row_length = KltPatch::row_length;

/// Product in 1/32768, rounded: the same as the SIMD instruction pmulhrsw.
int scaled(int value, int fraction) { return (value * fraction + 0x4000) >> 15; }

/// Interpolated intensities of `count` columns and `rows` rows from the corner on; row i at out + i * row_length.
void interpolate_plain(const KltWindow& window, int count, int rows, std::int16_t* out) {
  std::int16_t across[2][row_length + 2];
  for (int y = 0; y <= rows; ++y) {
    const std::uint8_t* pixels = window.row(y);
    for (int x = 0; x < count; ++x) {
      const int left = pixels[x] << 5;
      across[y & 1][x] = static_cast<std::int16_t>(left + scaled((pixels[x + 1] << 5) - left, window.fraction_x));
    }
    if (y == 0) continue;
    const std::int16_t *above = across[(y - 1) & 1], *below = across[y & 1];
    for (int x = 0; x < count; ++x) {
      out[(y - 1) * row_length + x] =
          static_cast<std::int16_t>(above[x] + scaled(below[x] - above[x], window.fraction_y));
    }
  }
}

void cut_plain(const KltWindow& window, int size, KltPatch& patch) {
  // Up to 33 columns: rows of the buffer are longer than the patch's.
  constexpr int most = KltPatch::most_rows + 2;
  std::int16_t wide[most][most];
  {
    std::int16_t across[2][most];
    for (int y = 0; y <= size + 2; ++y) {
      const std::uint8_t* pixels = window.row(y - 1) - 1;
      for (int x = 0; x < size + 2; ++x) {
        const int left = pixels[x] << 5;
        across[y & 1][x] = static_cast<std::int16_t>(left + scaled((pixels[x + 1] << 5) - left, window.fraction_x));
      }
      if (y == 0) continue;
      for (int x = 0; x < size + 2; ++x) {
        const int above = across[(y - 1) & 1][x];
        wide[y - 1][x] = static_cast<std::int16_t>(above + scaled(across[y & 1][x] - above, window.fraction_y));
      }
    }
  }
  patch.size = size;
  patch.xx = patch.xy = patch.yy = patch.x = patch.y = 0;
  for (int x = 0; x < row_length; ++x) patch.ones[x] = x < size ? 1 : 0;
  for (int y = 0; y < size; ++y) {
    const auto smooth_down = [&](int x) { return (wide[y][x] + 2 * wide[y + 1][x] + wide[y + 2][x] + 2) >> 2; };
    const auto smooth_across = [&](int r, int x) {
      return (wide[r][x] + 2 * wide[r][x + 1] + wide[r][x + 2] + 2) >> 2;
    };
    std::int16_t* intensity = patch.intensity + y * row_length;
    std::int16_t* gradient_x = patch.gradient_x + y * row_length;
    std::int16_t* gradient_y = patch.gradient_y + y * row_length;
    for (int x = 0; x < row_length; ++x) {
      if (x >= size) {
        intensity[x] = gradient_x[x] = gradient_y[x] = 0;
        continue;
      }
      intensity[x] = wide[y + 1][x + 1];
      const int gx = (smooth_down(x + 2) - smooth_down(x)) >> 2;
      const int gy = (smooth_across(y + 2, x) - smooth_across(y, x)) >> 2;
      gradient_x[x] = static_cast<std::int16_t>(gx);
      gradient_y[x] = static_cast<std::int16_t>(gy);
      patch.xx += gx * gx;
      patch.xy += gx * gy;
      patch.yy += gy * gy;
      patch.x += gx;
      patch.y += gy;
    }
  }
}

KltMismatch mismatch_plain(const KltWindow& window, const KltPatch& patch) {
  std::int16_t current[KltPatch::most_rows * row_length];
  interpolate_plain(window, patch.size, patch.size, current);
  KltMismatch sums;
  for (int y = 0; y < patch.size; ++y) {
    for (int i = y * row_length; i < y * row_length + patch.size; ++i) {
      const int difference = current[i] - patch.intensity[i];
      sums.ex += difference * patch.gradient_x[i];
      sums.ey += difference * patch.gradient_y[i];
      sums.e += difference;
    }
  }
  return sums;
}

KltResidual residual_plain(const KltWindow& window, const KltPatch& patch) {
  std::int16_t current[KltPatch::most_rows * row_length];
  interpolate_plain(window, patch.size, patch.size, current);
  KltResidual sums;
  for (int y = 0; y < patch.size; ++y) {
    for (int i = y * row_length; i < y * row_length + patch.size; ++i) {
      const int difference = (current[i] - patch.intensity[i]) >> 2;
      const int value = patch.intensity[i] >> 2;
      sums.squared_difference += difference * difference;
      sums.difference += difference;
      sums.squared_patch += value * value;
      sums.patch += value;
    }
  }
  return sums;
}

void rotate_plain(const KltRotation& rotation, std::uint8_t* rotated) {
  const std::int32_t most = (rotation.side - 1) * 65536 - 1;
  for (int y = 0; y < rotation.rows; ++y) {
    std::int32_t at_x = rotation.x + y * rotation.down_x, at_y = rotation.y + y * rotation.down_y;
    std::uint8_t* out = rotated + y * KltRotation::row_length;
    for (int x = 0; x < rotation.rows; ++x, at_x += rotation.across_x, at_y += rotation.across_y) {
      const std::int32_t px = std::clamp(at_x, 0, most), py = std::clamp(at_y, 0, most);
      const std::uint8_t* pixel = rotation.pixels + (py >> 16) * rotation.side + (px >> 16);
      const int fx = (px >> 8) & 255, fy = (py >> 8) & 255;
      const int upper = pixel[0] * (256 - fx) + pixel[1] * fx;
      const int lower = pixel[rotation.side] * (256 - fx) + pixel[rotation.side + 1] * fx;
      out[x] = static_cast<std::uint8_t>((upper * (256 - fy) + lower * fy + 32768) >> 16);
    }
  }
}

}  // namespace

const KltKernels& klt_kernels_plain() {
  static const KltKernels kernels{cut_plain, mismatch_plain, residual_plain, rotate_plain};
  return kernels;
}

const KltKernels& klt_kernels() { return simd_level() == SimdLevel::avx2 ? klt_kernels_avx2() : klt_kernels_plain(); }

}  // namespace rastro
