// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/image/padded_image.h"

namespace rastro {

/// The inner loops of KLT in fixed point: intensities in 1/32 grey level, gradients in 1/16 grey level per pixel.
/// Rows are 32 values long; what lies behind the window is zero in the gradients and the ones, and so takes no part.
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

/// What is left after alignment; in (1/8 grey level)^2 and 1/8 grey level.
struct KltResidual {
  std::int64_t squared_difference = 0, difference = 0, squared_patch = 0, patch = 0;
};

/// Where a window of a level begins: whole pixel of its upper left corner, and the fraction in 1/32768 pixel.
struct KltCorner {
  int x = 0, y = 0;
  std::int16_t fraction_x = 0, fraction_y = 0;
};

/// `kernels` for a processor: each pair of functions gives equal results.
struct KltKernels {
  /// Cuts the window at `corner` with its gradients (Sobel on the interpolated pixels); reads one pixel more on each side.
  void (*cut)(const PaddedImage& image, const KltCorner& corner, int size, KltPatch& patch);
  KltMismatch (*mismatch)(const PaddedImage& image, const KltCorner& corner, const KltPatch& patch);
  KltResidual (*residual)(const PaddedImage& image, const KltCorner& corner, const KltPatch& patch);
};

const KltKernels& klt_kernels_plain();
const KltKernels& klt_kernels_avx2();  ///< The plain ones where this build has no AVX2 code.
/// The best this processor has (base/simd.h).
const KltKernels& klt_kernels();

}  // namespace rastro
