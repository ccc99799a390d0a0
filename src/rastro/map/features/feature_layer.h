// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/feature/features.h"
#include "rastro/feature/orb.h"
#include "rastro/map/keyframe_layer.h"

namespace rastro {

/// What was found in one image. Never changes once made.
struct ImageFeatures {
  KeyframeId id = no_keyframe;  ///< Of the keyframe made of the image; no_keyframe: none yet.
  std::int64_t frame = 0;       ///< Index in the recording.
  TimeNs stamp = 0;
  Features features;           ///< Pixels as recorded, distortion included.
  std::vector<float> right_x;  ///< Stereo: where the right camera sees each feature, pixels; < 0: unknown.
  std::vector<float> depths;   ///< Along the optical axis, in the map's unit; 0: unknown. One a feature, or none.
};

/// The features of each keyframe.
struct FeatureLayer : KeyframeLayer<ImageFeatures> {
  static constexpr const char* layer_name = "features";
  OrbOptions extraction;  ///< How ORB features were made; who localizes in the map makes them the same way.
};

std::unique_ptr<LayerType> features_layer_type();

}  // namespace rastro
