// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "rastro/image/padded_image.h"
#include "rastro/math/se3.h"
#include "rastro/slam/lsd/tracking/alignment_reference.h"

namespace rastro {

/// Points per chunk: each has its own sums, which are added in order, so that they are the same for any number of
/// threads. A multiple of eight.
constexpr int alignment_chunk = 256;
/// Columns of a linearized residual: derivatives by (translation, rotation, gain, offset), and the residual itself.
constexpr int alignment_columns = 9;
constexpr int alignment_products = alignment_columns * (alignment_columns + 1) / 2;

struct PhotometricNoise {
  double intensity_sigma = 3.0;  ///< Of one image, intensity levels: noise, interpolation and what the model misses.
  double huber_width = 1.345;    ///< Standard deviations.
  /// Intensities beyond these are clipped by the sensor and say nothing about the brightness.
  double darkest = 1.0, brightest = 254.0;
};

/// All that one evaluation of the residuals depends on besides the points, in the precision of the inner loop.
struct AlignmentView {
  const std::uint8_t* pixels = nullptr;
  int stride = 0;
  float last_x = 0.0F, last_y = 0.0F;           ///< Samples are left of and above the last column and row.
  float rotation[9] = {}, translation[3] = {};  ///< Of image_from_reference, row by row.
  float fx = 0.0F, fy = 0.0F, cx = 0.0F, cy = 0.0F;
  float gradient_turn[4] =
      {};  ///< Gradient in the image from that in the reference: gain * the rotation about the axis.
  float gain = 1.0F, offset = 0.0F;  ///< image = gain * (reference - mid_intensity) + offset.
  float noise_variance = 0.0F;       ///< Of the difference of two images' intensities.
  float huber_width = 0.0F, darkest = 0.0F, brightest = 0.0F;
};

AlignmentView alignment_view(const PaddedImage& image, const LevelCamera& camera, const SE3& image_from_reference,
                             double gain, double offset, const PhotometricNoise& noise);

/// The linearized residuals of one chunk. Everything is 0 for points that do not project into the image.
struct AlignmentColumns {
  alignas(32) float column[alignment_columns][alignment_chunk];
  alignas(32) float weight[alignment_chunk];  ///< Huber weight / variance; 0 for points without a residual.
  alignas(32) float cost_lanes[8];            ///< Huber costs, sums over every eighth point.
  int points = 0;                             ///< Rounded up to a multiple of eight.
  int inside = 0;                             ///< Project into the image.
  int used = 0;                               ///< Of these, with an intensity that is not clipped.
  int inliers = 0;                            ///< Of these, within three standard deviations.
};

/// Sums over the points of a chunk.
struct AlignmentSums {
  std::array<double, alignment_products> products{};  ///< weight * column i * column j for i <= j, by rows.
  double cost = 0.0;                                  ///< Huber, in squared standard deviations.
  int inside = 0, used = 0, inliers = 0;

  AlignmentSums& operator+=(const AlignmentSums& other);
};

/// The inner loops for one processor type; each pair gives equal bytes.
struct AlignmentKernels {
  /// Residuals r = I(project(T * point)) - gain * I_ref - offset of the points [begin, end), divided by their standard
  /// deviation (Engel et al. 2014, equations 8 and 9), with their derivatives by d in T * exp(d). The gradient of the
  /// image is the reference's, rotated: at convergence they agree, and it must not be sampled at every step.
  void (*linearize)(const AlignmentPoints& points, int begin, int end, const AlignmentView& view,
                    AlignmentColumns& columns);
  void (*accumulate)(const AlignmentColumns& columns, AlignmentSums& sums);
};

const AlignmentKernels& alignment_kernels_plain();
const AlignmentKernels& alignment_kernels_avx2();  ///< The plain ones where this build has no AVX2 code.
/// Those of simd_level().
const AlignmentKernels& alignment_kernels();

}  // namespace rastro
