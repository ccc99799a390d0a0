// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/feature/features.h"
#include "rastro/feature/orb.h"
#include "rastro/map/keyframe_layer.h"

namespace rastro {

/// The features of one image. Immutable.
struct ImageFeatures {
  KeyframeId id = no_keyframe;  ///< Id of the keyframe made from the image; no_keyframe: none yet.
  std::int64_t frame = 0;       ///< Index in the recording.
  TimeNs stamp = 0;
  Features features;           ///< Pixels as recorded, distortion included.
  std::vector<float> right_x;  ///< Stereo: x of each feature in the right image, pixels; < 0: unknown.
  std::vector<float> depths;   ///< Along the optical axis, in the map's unit; 0: unknown. One per feature, or empty.
};

/// The same features as those of another keyframe.
std::shared_ptr<const ImageFeatures> with_id(const ImageFeatures& image, KeyframeId id);

/// The features of each keyframe.
struct FeatureLayer : KeyframeLayer<ImageFeatures> {
  static constexpr const char* layer_name = "features";
  OrbOptions extraction;  ///< Settings of the ORB extraction; localization in the map extracts with the same ones.
};

std::unique_ptr<LayerType> features_layer_type();

}  // namespace rastro
