// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/image/image.h"

namespace rastro {

struct StereoDepthOptions {
  double focal_times_baseline = 50.0;  ///< Pixels times meters: depth = this over disparity.
  double min_disparity_px = 2.0;       ///< A smaller one has no useful depth.
  int max_disparity_px = 96;           ///< Nearer points have no depth.
};

/// Depth of a rectified pair: semi-global matching of the images at half their size with a left-right check (OpenCV),
/// which is dense and fast, then precise by `refine_disparity`. Not thread-safe.
class StereoDepth {
 public:
  explicit StereoDepth(const StereoDepthOptions& options);
  ~StereoDepth();
  /// Meters in the left image, 0 where there is no certain match. Empty for images of different sizes.
  DepthImage depth(GrayView left, GrayView right) const;

 private:
  class Matcher;
  StereoDepthOptions options_;
  std::unique_ptr<Matcher> matcher_;
};

}  // namespace rastro
