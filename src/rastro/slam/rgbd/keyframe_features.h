// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/feature/descriptor_extractor.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/sensor/frame.h"
#include "rastro/slam/rgbd/options.h"

namespace rastro {

/// Features of a keyframe with their depths, spread over the picture. Not to be used by two threads at once.
class KeyframeFeatures {
 public:
  explicit KeyframeFeatures(const RgbdSlamOptions& options);
  /// Strongest first; nothing where the mask is zero. Only features and depths of the result are set.
  ImageFeatures extract(const Frame& frame);

 private:
  RgbdSlamOptions options_;
  std::unique_ptr<DescriptorExtractor> extractor_;
};

/// Median depth around a pixel; 0 where there is none, or where it jumps.
float feature_depth(const DepthImage& depth, float x, float y);

}  // namespace rastro
