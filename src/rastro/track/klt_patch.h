// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace rastro {

/// The inner loops of KLT in fixed point: intensities in 1/32 of a level, gradients in 1/16 level per pixel. Rows have
/// 32 values; beyond the window the gradients and the ones are zero, so these values have no effect.
struct alignas(64) KltPatch {
  static constexpr int row_length = 32;
  static constexpr int most_rows = 31;

  int size = 0;  ///< Side of the window.
  std::int16_t intensity[most_rows * row_length];
  std::int16_t gradient_x[most_rows * row_length];
  std::int16_t gradient_y[most_rows * row_length];
  std::int16_t ones[row_length];
  // Sums over the window.
  std::int64_t xx = 0, xy = 0, yy = 0, x = 0, y = 0;
};

/// Sums of the difference e = current - patch over the window.
struct KltMismatch {
  std::int64_t ex = 0, ey = 0, e = 0;
};

/// Residual after alignment, in (1/8 level)^2 and 1/8 level.
struct KltResidual {
  std::int64_t squared_difference = 0, difference = 0, squared_patch = 0, patch = 0;
};

/// A window in an image: the whole pixel its upper left corner lies in, and the fraction beyond in 1/32768 pixel. For
/// any window size, kernels read up to 48 pixels of each row, from one pixel left of the corner on.
struct KltWindow {
  const std::uint8_t* pixels = nullptr;
  std::ptrdiff_t stride = 0;
  std::int16_t fraction_x = 0, fraction_y = 0;

  const std::uint8_t* row(int y) const { return pixels + y * stride; }
};

/// A square image to be resampled with rotation and scale; positions and steps in 1/65536 pixel. Kernels read up to
/// three bytes behind its last pixel.
struct KltRotation {
  const std::uint8_t* pixels = nullptr;
  int side = 0;               ///< Pixels per row, and rows.
  std::int32_t x = 0, y = 0;  ///< Position of the first pixel of the rotated image.
  std::int32_t across_x = 0, across_y = 0, down_x = 0, down_y = 0;
  int rows = 0;  ///< And columns, of the rotated image.

  static constexpr int row_length = 48;
};

/// `kernels` for one processor type: each pair of functions gives equal results.
struct KltKernels {
  /// Cuts a window of `size` with its gradients (Sobel on the interpolated pixels); reads one pixel more on each side.
  void (*cut)(const KltWindow& window, int size, KltPatch& patch);
  KltMismatch (*mismatch)(const KltWindow& window, const KltPatch& patch);
  KltResidual (*residual)(const KltWindow& window, const KltPatch& patch);
  /// Bilinear, rounded; outside, the pixel at the edge is used. Columns behind the last one may be written, up to the
  /// next multiple of eight.
  void (*rotate)(const KltRotation& rotation, std::uint8_t* rotated);
};

const KltKernels& klt_kernels_plain();
const KltKernels& klt_kernels_avx2();  ///< The plain ones where this build has no AVX2 code.
/// The fastest this processor supports (base/simd.h).
const KltKernels& klt_kernels();

}  // namespace rastro
