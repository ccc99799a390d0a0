// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <array>
#include <cstdint>

#include "rastro/feature/brief.h"
#include "rastro/image/image.h"

namespace rastro {

/// What is described lies at most this far from the corner, in pixels of its level.
constexpr int orb_radius = 15;

/// Direction from a corner to the intensity centroid of the disc of orb_radius around it (Rosin 1999; Rublee et al.
/// 2011, section 3.2).
struct OrbDirection {
  /// Cosine and sine times 2^14, rounded.
  std::int16_t cosine = 1 << 14, sine = 0;
  float angle_rad = 0.0F;  ///< From x towards y.
};

/// `centre` is the corner's pixel; 16 pixels either side may be read.
OrbDirection orb_direction(const std::uint8_t* centre, std::ptrdiff_t stride);

/// Both ends of the binary tests, in pixels from the corner before turning.
using OrbPattern = std::array<std::array<std::int8_t, 4>, 256>;  ///< ax, ay, bx, by.
const OrbPattern& orb_pattern();

/// Steered BRIEF (Rublee et al. 2011, section 4) of the corner at `centre` of a smoothed image.
Descriptor orb_describe(const std::uint8_t* centre, std::ptrdiff_t stride, const OrbDirection& direction);

}  // namespace rastro
