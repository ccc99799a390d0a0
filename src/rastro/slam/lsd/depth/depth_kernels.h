// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "rastro/image/image.h"
#include "rastro/slam/lsd/inverse_depth_map.h"

namespace rastro {

/// Samples of a pixel's neighborhood along its epipolar line (Engel et al. 2013, section 2.1: five).
constexpr int epipolar_samples = 5;
/// Places on a line that are compared, at most.
constexpr int most_line_steps = 64;

/// Intensities at equal steps along a line; room for those that a vector reads past the end.
using LineIntensities = std::array<float, most_line_steps + epipolar_samples + 16>;
using LineCosts = std::array<float, most_line_steps + 8>;

/// Which intensities of an image to sample: at (x, y) + i * (step_x, step_y) for i of [0, count). All have a pixel to
/// the right and below.
struct LineSampling {
  GrayView image;
  float x = 0.0F, y = 0.0F, step_x = 0.0F, step_y = 0.0F;
  int count = 0;
};

struct SmoothingOptions {
  int border = 0;  ///< Pixels at the edge that are left out.
  int fewest = 3;  ///< Neighbors that agree, itself included.
  float max_sigmas = 2.0F;
  float slant = 0.01F;  ///< Change of the inverse depth per pixel of distance, as a share of it.
};

/// The inner loops for one processor type; each gives equal bytes.
struct DepthKernels {
  /// Bilinear. The image's rows must be readable 3 bytes beyond the last one's end, as those of Image are.
  void (*sample)(const LineSampling& line, LineIntensities& intensities);
  /// Mean squared difference of `seen` to the intensities [i, i + epipolar_samples) for i of [0, count).
  void (*compare)(const LineIntensities& intensities, const std::array<float, epipolar_samples>& seen, int count,
                  LineCosts& costs);
  /// Means of the pixels of a row over the 5 x 5 neighbors that agree with each, weighted by their variances (Engel et
  /// al. 2013, section 2.6), into `smoothed`; 0 where fewer agree.
  void (*smooth_row)(const InverseDepthMap& depth, int y, const SmoothingOptions& options, float* smoothed);
};

const DepthKernels& depth_kernels_plain();
const DepthKernels& depth_kernels_avx2();  ///< The plain ones where this build has no AVX2 code.
/// Those of simd_level().
const DepthKernels& depth_kernels();

}  // namespace rastro
