// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <array>
#include <cstdint>

#include "rastro/feature/brief.h"
#include "rastro/image/image.h"

namespace rastro {

/// Radius of the described patch, in pixels of its level.
constexpr int orb_radius = 15;

/// Orientation: direction from a corner to the intensity centroid of the disc of orb_radius around it (Rosin 1999;
/// Rublee et al. 2011, section 3.2).
struct OrbDirection {
  /// Cosine and sine times 2^14, rounded.
  std::int16_t cosine = 1 << 14, sine = 0;
  float angle_rad = 0.0F;  ///< From x towards y.
};

/// `center` is the corner's pixel; reads up to 16 pixels on either side.
OrbDirection orb_direction(const std::uint8_t* center, std::ptrdiff_t stride);

/// Both ends of the binary tests, in pixels from the corner before rotation.
using OrbPattern = std::array<std::array<std::int8_t, 4>, 256>;  ///< ax, ay, bx, by.
const OrbPattern& orb_pattern();

/// Steered BRIEF (Rublee et al. 2011, section 4) of the corner at `center` of a smoothed image.
Descriptor orb_describe(const std::uint8_t* center, std::ptrdiff_t stride, const OrbDirection& direction);

}  // namespace rastro
