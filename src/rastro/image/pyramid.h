// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/image/padded_image.h"

namespace rastro {

/// Image pyramid by the binomial filter [1 4 6 4 1]/16 in both directions and every second pixel (Burt and Adelson
/// 1983): pixel (x, y) of level l lies at (x, y) * 2^l of level 0. Each level may be read `padding` pixels outside.
class Pyramid {
 public:
  /// Copies `image` and makes up to `levels` levels, fewer if one would be smaller than 8 pixels.
  void build(GrayView image, int levels, int padding, TaskPool* pool = nullptr);
  int levels() const { return used_; }
  const PaddedImage& level(int index) const { return levels_[static_cast<std::size_t>(index)]; }

 private:
  std::vector<PaddedImage> levels_;
  int used_ = 0;
};

/// Halves `source` (its padding filled, at least 2) into `target`, whose size is set to (w+1)/2 x (h+1)/2; the target's
/// padding is filled.
void halve(const PaddedImage& source, PaddedImage& target, TaskPool* pool = nullptr);

}  // namespace rastro
