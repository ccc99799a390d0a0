// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/slam/lsd/inverse_depth_map.h"

namespace rastro {

struct SmoothingOptions {
  int border = 0;  ///< Pixels at the edge that are left out, at least 2.
  int fewest = 3;  ///< Neighbors that agree, itself included.
  float max_sigmas = 2.0F;
  float slant = 0.01F;  ///< Change of the inverse depth per pixel of distance, as a share of it.
};

/// A row of an inverse depth map, from a pixel on that has zeros before it; behind the row follow 16 of them.
struct HalvingRow {
  const float *mean, *variance;
};

/// Weighted sums of the pixels that contribute to each pixel of a row of half the size; room for a multiple of eight.
struct HalvingSums {
  float *precision, *weighted, *squares;  ///< Sums of weight / variance, that times the mean, and times its square.
  float* weight;                          ///< Sum of the binomial weights.
};

/// The inner loops for one processor type; each gives equal bytes.
struct DepthKernels {
  /// Means of the pixels of a row over the 5 x 5 neighbors that agree with each, weighted by their variances (Engel et
  /// al. 2013, section 2.6), into `smoothed`; 0 where fewer agree.
  void (*smooth_row)(const InverseDepthMap& depth, int y, const SmoothingOptions& options, float* smoothed);
  /// Unknown pixels of [begin, end) of a row with at least `fewest` known ones among the eight around them, into
  /// `places`. Returns how many.
  int (*find_holes)(const InverseDepthMap& depth, int y, int begin, int end, int fewest, int* places);
  /// Adds a row to the sums of a row of half its size, with the weights [1 2 1] times `weight`.
  void (*add_row)(const HalvingRow& row, float weight, int width, HalvingSums& sums);
  /// Writes up to the next multiple of eight.
  void (*divide)(const HalvingSums& sums, int width, float* mean, float* variance);
};

const DepthKernels& depth_kernels_plain();
const DepthKernels& depth_kernels_avx2();  ///< The plain ones where this build has no AVX2 code.
/// Those of simd_level().
const DepthKernels& depth_kernels();

}  // namespace rastro
