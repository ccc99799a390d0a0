// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/feature/descriptor_extractor.h"
#include "rastro/image/image.h"

namespace rastro {

/// The pictures of a depth camera, packed.
struct PackedPictures {
  std::vector<std::uint8_t> colour;  ///< JPEG, three channels, or one where the camera is grey.
  std::vector<std::uint8_t> depth;   ///< PNG, 16 bits, `packed_depth_units_per_metre`; 0 = no measurement.

  std::size_t bytes() const { return colour.size() + depth.size(); }
  bool operator==(const PackedPictures&) const = default;
};

constexpr double packed_depth_units_per_metre = 5000.0;

/// The pictures again. Grey sources give a colour image of three equal channels.
struct UnpackedPictures {
  ColourImage colour;
  DepthImage depth;  ///< Metres, 0 = none.
};

/// A place where packed pictures are kept: in memory, or in a map file. May be asked by several threads.
class PictureStore {
 public:
  virtual ~PictureStore() = default;
  /// Error where they cannot be read.
  virtual PackedPictures pictures(std::int64_t keyframe_id) const = 0;
};

/// A frame of a depth camera that is kept, without its pose, which the graph has. Never changes once made.
struct RgbdKeyframe {
  std::int64_t id = 0;     ///< Running number of the map, from 0, in the order of creation.
  std::int64_t frame = 0;  ///< Index in the recording.
  TimeNs stamp = 0;        ///< Of the colour picture.
  DescribedKeypoints features;
  std::vector<float> depths;  ///< Of each feature along the optical axis, metres; 0 = not measured.
};

}  // namespace rastro
