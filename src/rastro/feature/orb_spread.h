// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstddef>
#include <vector>

#include "rastro/feature/fast.h"

namespace rastro {

/// The corners of one level in the cells of a grid, each cell's best first.
class OrbCells {
 public:
  /// Sorts `corners` (given row by row) of the area [x0, x1) x [y0, y1) into cells for about `wanted` of them. In a
  /// cell that has corners with scores above `threshold`, the others are dropped.
  OrbCells(const std::vector<FastCorner>& corners, int x0, int x1, int y0, int y1, int wanted, int threshold);

  /// Number of corners left.
  std::size_t size() const { return corners_.size(); }
  /// Selects up to `quota` corners: every cell's best, every cell's second best and so on; of the last round the best
  /// by score. Ordered by row, then column.
  std::vector<FastCorner> take(std::size_t quota) const;

 private:
  std::vector<FastCorner> corners_;
  std::vector<std::size_t> first_;  ///< First index of each cell, and the end.
};

/// Number of features per level: proportional to the sides of the levels. What a level cannot fill goes to finer
/// levels, then to coarser ones. `available`: corners of each level.
std::vector<std::size_t> orb_quotas(std::size_t features, double scale_factor,
                                    const std::vector<std::size_t>& available);

}  // namespace rastro
