// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/image/image.h"
#include "rastro/map/layer_type.h"

namespace rastro {

/// The images of a depth camera, packed.
struct PackedPictures {
  std::vector<std::uint8_t> colour;  ///< JPEG, three channels, or one where the camera is gray.
  std::vector<std::uint8_t> depth;   ///< PNG, 16 bits, `packed_depth_units_per_metre`; 0 = no measurement.

  std::size_t bytes() const { return colour.size() + depth.size(); }
  bool operator==(const PackedPictures&) const = default;
};

constexpr double packed_depth_units_per_metre = 5000.0;

/// The images again. Gray sources give a color image of three equal channels.
struct UnpackedPictures {
  ColourImage colour;
  DepthImage depth;  ///< Metres, 0 = none.
};

/// Where packed images are kept: in memory, or in a map file. May be asked by several threads.
class PictureStore {
 public:
  virtual ~PictureStore() = default;
  /// Error where they cannot be read.
  virtual PackedPictures pictures(KeyframeId keyframe) const = 0;
};

/// Color and depth image of keyframes, read when asked for.
struct ImageLayer : Layer {
  static constexpr const char* layer_name = "images";
  std::shared_ptr<const PictureStore> store;
  std::vector<KeyframeId> keyframes;  ///< That have images; ascending.
};

/// Those of a map; null where it has none.
std::shared_ptr<const PictureStore> images_of(const Map& map);

std::unique_ptr<LayerType> images_layer_type();

}  // namespace rastro
