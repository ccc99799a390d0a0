// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "rastro/image/image.h"

namespace rastro {

/// Where new corners may be detected: outside the mask and not within a distance of a feature. Keeps its memory between
/// frames.
class FreeArea {
 public:
  /// Starts from the mask (zero: not free), or with everything free if it is empty.
  void reset(int width, int height, GrayView mask);
  /// Removes the disc of `radius` pixels around `center`.
  void block(const Eigen::Vector2f& center, double radius);
  GrayView view() const { return area_.view(); }

 private:
  GrayImage area_;
  std::vector<int> half_widths_;  ///< Per row of the disc, by distance from the middle row.
  double radius_ = -1.0;
};

}  // namespace rastro
