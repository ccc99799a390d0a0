// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/feature/features.h"
#include "rastro/image/image.h"

namespace rastro {

struct OrbOptions {
  int features = 1000;           ///< At most, over all levels.
  int levels = 8;                ///< Of the image pyramid.
  double scale_factor = 1.2;     ///< From one level to the next.
  int fast_threshold = 20;       ///< Intensity threshold of the corner test...
  int least_fast_threshold = 7;  ///< ... and in a cell without such a corner.
  bool operator==(const OrbOptions&) const = default;
};

/// Size of a pixel of a level in pixels of the image: scale_factor^level.
std::vector<double> orb_level_scales(const OrbOptions& options);

/// Oriented FAST and rotated BRIEF (Rublee et al. 2011) on an image pyramid, distributed evenly over the image
/// (Mur-Artal et al. 2015, section IV). Keeps its buffers between calls; not thread-safe.
class OrbExtractor {
 public:
  /// Throws Error for options out of range.
  explicit OrbExtractor(const OrbOptions& options);
  ~OrbExtractor();
  /// Changes the number of features of the following images. Throws Error as the constructor does.
  void set_features(int features);
  /// No keypoints where `mask` (empty or of the image's size) is zero, nor on levels for which the image is too small.
  /// The result depends neither on the pool nor on the processor. Every keypoint has its level; their order depends
  /// only on image and options.
  Features extract(GrayView image, GrayView mask = {}, TaskPool* pool = nullptr);

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
