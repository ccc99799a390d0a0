// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/math/se3.h"
#include "rastro/slam/lsd/tracking/alignment_kernels.h"

namespace rastro {

/// Intensity in the image = gain * (intensity in the reference - mid_intensity) + offset.
struct AffineBrightness {
  double gain = 1.0;
  double offset = static_cast<double>(AlignmentPoints::mid_intensity);

  /// A gain far off makes any image fit: a flat one.
  bool plausible() const { return gain > 0.1 && gain < 10.0; }
  /// The offset for intensities that are not relative to mid_intensity.
  double absolute_offset() const { return offset - gain * static_cast<double>(AlignmentPoints::mid_intensity); }
};

/// The change of brightness that gives the points' intensities the mean and spread that the image has where they
/// project to: hardly depends on the motion, so it can be estimated before that. None if the points are too few.
AffineBrightness matched_brightness(const AlignmentPoints& points, const PaddedImage& image,
                                    const SE3& image_from_reference, const PhotometricNoise& noise);

}  // namespace rastro
