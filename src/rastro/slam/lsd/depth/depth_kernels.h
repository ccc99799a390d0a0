// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/slam/lsd/inverse_depth_map.h"

namespace rastro {

struct SmoothingOptions {
  int border = 0;  ///< Pixels at the edge that are left out.
  int fewest = 3;  ///< Neighbors that agree, itself included.
  float max_sigmas = 2.0F;
  float slant = 0.01F;  ///< Change of the inverse depth per pixel of distance, as a share of it.
};

/// The inner loops for one processor type; each gives equal bytes.
struct DepthKernels {
  /// Means of the pixels of a row over the 5 x 5 neighbors that agree with each, weighted by their variances (Engel et
  /// al. 2013, section 2.6), into `smoothed`; 0 where fewer agree.
  void (*smooth_row)(const InverseDepthMap& depth, int y, const SmoothingOptions& options, float* smoothed);
};

const DepthKernels& depth_kernels_plain();
const DepthKernels& depth_kernels_avx2();  ///< The plain ones where this build has no AVX2 code.
/// Those of simd_level().
const DepthKernels& depth_kernels();

}  // namespace rastro
