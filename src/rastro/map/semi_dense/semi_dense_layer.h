// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "rastro/map/keyframe_layer.h"

namespace rastro {

/// Inverse depth of the pixels of a keyframe where the image has gradient; Engel et al. 2013, section 2.
struct SemiDenseDepth {
  struct Pixel {
    std::uint16_t x = 0, y = 0;
    float inverse_depth = 0.0F;  ///< Inverse of the map's unit, along the optical axis; > 0.
    float variance = 0.0F;       ///< Of the inverse depth.
    std::uint8_t intensity = 0;
  };
  std::vector<Pixel> pixels;  ///< Row by row.
};

/// Semi-dense depth of each keyframe that has some.
struct SemiDenseLayer : KeyframeLayer<SemiDenseDepth> {
  static constexpr const char* layer_name = "semi_dense";
};

std::unique_ptr<LayerType> semi_dense_layer_type();

}  // namespace rastro
