// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/image/image.h"
#include "rastro/map/stored_layer.h"

namespace rastro {

/// The images of a depth camera, packed.
struct PackedImages {
  std::vector<std::uint8_t> color;  ///< JPEG, three channels, or one where the camera is gray.
  std::vector<std::uint8_t> depth;  ///< As pack_depth() makes it; in maps before version 4 PNG of 16 bits.

  std::size_t bytes() const { return color.size() + depth.size(); }
  bool operator==(const PackedImages&) const = default;
};

/// The decoded images. A gray source gives a color image with three equal channels.
struct UnpackedImages {
  ColorImage color;
  DepthImage depth;  ///< Meters, 0 = none.
};

/// Storage of packed images: in memory, or in a map file.
using ImageStore = ItemStore<PackedImages>;

/// Color and depth image of keyframes, read on demand.
struct ImageLayer : StoredLayer<PackedImages> {
  static constexpr const char* layer_name = "images";
};

/// The images of a map; null where it has none.
std::shared_ptr<const ImageStore> images_of(const Map& map);

std::unique_ptr<LayerType> images_layer_type();

}  // namespace rastro
