// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/image/padded_image.h"

namespace rastro {

struct Corner {
  int x = 0;
  int y = 0;
  float score = 0.0F;
};

struct CornerOptions {
  /// A corner's score is at least this share of the best in the free area (Shi and Tomasi 1994).
  double quality = 0.01;
  double min_distance_px = 30.0;  ///< Between two corners.
  int border_px = 1;              ///< Minimum distance to the image's edge.
};

/// Shi-Tomasi corners in the free part of an image. Processes only tiles with free pixels, so a frame whose features
/// are nearly all tracked costs little. Keeps its buffers between calls.
class CornerDetector {
 public:
  CornerDetector();
  ~CornerDetector();

  /// Up to `count` corners where `free` is not zero, strongest first (equal scores: upper, then left one first), each
  /// at least min_distance from all before it. `free` has the image's size. Local maxima are over 3x3 pixels, masked
  /// neighbors included. The result does not depend on the pool.
  std::vector<Corner> detect(const PaddedImage& image, GrayView free, int count, const CornerOptions& options,
                             TaskPool* pool = nullptr);

  /// Number of local maxima above the quality threshold in the last call.
  int candidates() const { return candidates_; }

 private:
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
  int candidates_ = 0;
};

}  // namespace rastro
