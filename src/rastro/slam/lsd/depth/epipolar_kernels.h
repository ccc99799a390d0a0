// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "rastro/image/image.h"

namespace rastro {

/// Samples of a pixel's neighborhood along its epipolar line (Engel et al. 2013, section 2.1: five).
constexpr int epipolar_samples = 5;
/// Places on a line that are compared, at most.
constexpr int most_line_steps = 64;
/// Pixels of one call; a multiple of eight.
constexpr int epipolar_batch = 256;

/// All that a search depends on besides the pixels, in the precision of the inner loop.
struct EpipolarView {
  GrayView keyframe, image;
  GrayView mask;                                                ///< Of the image; empty: nothing is left out.
  float rotation[9] = {}, translation[3] = {}, center[3] = {};  ///< image_from_keyframe; its center in the keyframe.
  float fx = 1.0F, fy = 1.0F, cx = 0.0F, cy = 0.0F;
  float gain = 1.0F, offset = 0.0F;
  float min_line_px = 1.0F, half_length_px = 20.0F, min_gradient = 3.0F;  ///< The gradient in the image.
  float intensity_variance = 18.0F;                                       ///< Of a difference between both images.
  float most_residual = 162.0F;                                           ///< Mean square.
  float squared_second_ratio = 2.25F;
  float disparity_sigma_px = 0.1F, geometry_variance = 0.16F;
};

/// Pixels of the keyframe with what is known of their inverse depths.
struct EpipolarQueries {
  int count = 0;
  bool known = false;  ///< Else an ambiguous match is none.
  using Values = std::array<float, epipolar_batch>;
  Values x{}, y{}, least{}, expected{}, most{};
  Values worthwhile_variance{};  ///< Larger variances are not worth a search.
};

struct EpipolarMatches {
  std::array<float, epipolar_batch> mean{}, variance{};
  std::array<std::int32_t, epipolar_batch> result{};  ///< EpipolarResult.
};

/// For one processor type; each gives equal bytes. The images' rows must be readable 3 bytes beyond the last one's end,
/// as those of Image are.
struct EpipolarKernels {
  void (*search)(const EpipolarView& view, const EpipolarQueries& queries, EpipolarMatches& matches);
};

const EpipolarKernels& epipolar_kernels_plain();
const EpipolarKernels& epipolar_kernels_avx2();  ///< The plain ones where this build has no AVX2 code.
/// Those of simd_level().
const EpipolarKernels& epipolar_kernels();

}  // namespace rastro
