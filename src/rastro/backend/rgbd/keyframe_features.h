// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/backend/rgbd/options.h"
#include "rastro/feature/descriptor_extractor.h"
#include "rastro/feature/orb.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/graph/map.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// Features of a keyframe with their depths, spread over the image. Not thread-safe.
class KeyframeFeatures {
 public:
  explicit KeyframeFeatures(const RgbdSlamOptions& options);
  /// None where the mask is zero; strongest first, but for "even_orb". Sets only features and depths of the result.
  /// `share`: fraction of the usual number of features.
  ImageFeatures extract(const Frame& frame, double share = 1.0);

 private:
  RgbdSlamOptions options_;
  Features detect(const Frame& frame, std::size_t most);

  std::unique_ptr<OrbExtractor> orb_;               ///< For descriptor "even_orb" ...
  std::unique_ptr<DescriptorExtractor> extractor_;  ///< ... and for the others.
};

/// Median depth around a pixel; 0 where there is none, or at a depth discontinuity: more than the noise explains.
float feature_depth(const DepthImage& depth, float x, float y, const DepthNoise& noise = {});

}  // namespace rastro
