// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/slam/lsd/tracking/alignment_kernels.h"

namespace rastro {

/// Share of the regions of the image (neighbors of alignment_chunk points) in which the intensities of the reference
/// and of the image are correlated by at least `min_correlation` at this pose. Small residuals are no proof that both
/// show the same: uncertain depths allow for large ones, and smooth images fit each other anywhere. 0: no region can be
/// judged.
double correlated_share(const AlignmentPoints& points, const PaddedImage& image, const SE3& image_from_reference,
                        const PhotometricNoise& noise, double min_correlation);

}  // namespace rastro
