// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "rastro/image/image.h"

namespace rastro {

/// Where new corners may be: outside the mask and nowhere nearer than a distance to a feature. Keeps its memory between
/// frames.
class FreeArea {
 public:
  /// Starts from the mask (zero: not free), or all free when it is empty.
  void reset(int width, int height, GreyView mask);
  /// Takes the disc of `radius` pixels around `centre` out.
  void block(const Eigen::Vector2f& centre, double radius);
  GreyView view() const { return area_.view(); }

 private:
  GreyImage area_;
  std::vector<int> half_widths_;  ///< Of the disc's rows, by distance from the middle row.
  double radius_ = -1.0;
};

}  // namespace rastro
