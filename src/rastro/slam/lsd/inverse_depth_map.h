// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/image/image.h"

namespace rastro {

/// Inverse depth of the pixels of a keyframe where it is known, as a Gaussian each (Engel et al. 2013, section 2.1).
struct InverseDepthMap {
  Image<float> mean;      ///< Inverse of the map's unit, along the optical axis.
  Image<float> variance;  ///< Of the mean; 0: the depth of this pixel is not known.

  InverseDepthMap() = default;
  InverseDepthMap(int width, int height) : mean(width, height), variance(width, height) {}

  int width() const { return mean.width(); }
  int height() const { return mean.height(); }
  bool is_known(int x, int y) const { return variance.at(x, y) > 0.0F; }
};

}  // namespace rastro
