// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "rastro/feature/brief.h"

namespace rastro {

struct Keypoint {
  float x = 0.0F, y = 0.0F;  ///< Pixels of the full image.
  float size_px = 0.0F;      ///< Diameter of the described patch.
  float angle_rad = 0.0F;    ///< Orientation, from x towards y.
  float response = 0.0F;     ///< Strength; the unit is the extractor's own.
};

/// Keypoints with a descriptor each: either `length` floats compared by Euclidean distance, or 256 bits compared by
/// Hamming distance (then length is 0).
struct Features {
  std::vector<Keypoint> keypoints;
  std::vector<std::uint8_t> levels;  ///< Pyramid level, one per keypoint; empty if the extractor has none.
  int length = 0;
  std::vector<float> floats;            ///< keypoints.size() * length, one keypoint after the other.
  std::vector<Descriptor> descriptors;  ///< One per keypoint, or none.

  std::size_t size() const { return keypoints.size(); }
  bool binary() const { return length == 0; }
};

}  // namespace rastro
