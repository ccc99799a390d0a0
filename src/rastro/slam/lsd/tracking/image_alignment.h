// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/base/task_pool.h"
#include "rastro/image/pyramid.h"
#include "rastro/math/se3.h"
#include "rastro/slam/lsd/tracking/alignment_kernels.h"
#include "rastro/slam/lsd/tracking/alignment_reference.h"

namespace rastro {

enum class AlignmentFailure {
  none,
  too_few_points,  ///< The reference, or what of it is neither outside nor clipped, has too few; or they leave a
                   ///< direction undetermined.
  low_overlap,     ///< Too few of the reference's points project into the image.
  large_residual,  ///< Too few of the points fit the image.
};
const char* to_string(AlignmentFailure failure);

struct ImageAlignmentOptions {
  int coarsest_level = 4;  ///< Or the last one that both sides have.
  int finest_level = 0;
  int iterations = 20;             ///< On each level.
  double epsilon_px = 0.01;        ///< Converged when a step moves the points less, on the finest level.
  double coarse_epsilon_px = 0.1;  ///< On the others, in their own pixels.
  PhotometricNoise noise;
  int min_points = 100;           ///< On the finest level.
  double min_overlap = 0.3;       ///< Share of the reference's points.
  double min_correlation = 0.5;   ///< Of a region in which both images show the same.
  double min_inlier_share = 0.5;  ///< Share of the points within three standard deviations.
};

struct ImageAlignment {
  SE3 image_from_reference;
  /// Intensity in the image = gain * intensity in the reference + offset. Interpolation blurs: on sharp images the gain
  /// is up to 7 % low.
  double gain = 1.0, offset = 0.0;
  /// Of d in true image_from_reference = image_from_reference * exp(d): (translation, rotation). From this image's and
  /// the depth's noise as the residuals show it; what all images have in common (the scale of the depth, calibration)
  /// is not in it.
  Matrix6d covariance = Matrix6d::Zero();
  double rms = 0.0;           ///< Robust root mean square of the residuals, standard deviations.
  double overlap = 0.0;       ///< Share of the reference's points that project into the image.
  double inlier_share = 0.0;  ///< Share of the points that are compared within three standard deviations.
  /// Share of the regions of the image (neighbors of alignment_chunk points) in which most points fit: something that
  /// hides a part of the view leaves all its regions without.
  double region_share = 0.0;
  /// Share of these regions in which both images are correlated: see correlated_share().
  double alike_share = 0.0;
  int points = 0;          ///< Compared.
  bool converged = false;  ///< On the finest level.
  AlignmentFailure failure = AlignmentFailure::too_few_points;

  bool ok() const { return failure == AlignmentFailure::none; }
  /// Standard deviation of the translation as a share of it; infinite where the camera stands still.
  double motion_error() const;
};

/// Motion of a camera against a keyframe: minimizes the variance-normalized photometric residuals of the keyframe's
/// points with Huber weights from coarse to fine (Engel et al. 2014, section 3.3), with an affine change of brightness
/// between the images as in Engel et al. 2015, "Large-scale direct SLAM with stereo cameras". `image`: made by
/// alignment_pyramid(), of the reference's camera. The same bytes for any pool and SIMD level.
ImageAlignment align_image(const AlignmentReference& reference, const Pyramid& image,
                           const SE3& image_from_reference_guess, const ImageAlignmentOptions& options = {},
                           TaskPool* pool = nullptr);

}  // namespace rastro
