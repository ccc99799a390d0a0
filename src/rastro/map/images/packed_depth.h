// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rastro/image/image.h"

namespace rastro {

constexpr double packed_depth_units_per_meter = 5000.0;

/// Packs a depth image, in meters: each depth in units as the difference to the last one measured before it in its row,
/// its zigzag number in 1 to 3 bytes, all compressed by zstd. Lossless but for the rounding to units; what is no depth,
/// or beyond the 13.1 m that fit 16 bits, becomes 0. The same bytes for the same depths. Faster than PNG, and smaller.
std::vector<std::uint8_t> pack_depth(const DepthImage& depth);

/// The depths again, in meters, 0 = none; also of the 16-bit PNG images in maps before version 4. nullopt for bytes
/// that are neither, and for images of more pixels than are decoded.
std::optional<DepthImage> unpack_depth(std::span<const std::uint8_t> bytes);

/// What packing leaves of a depth image.
DepthImage rounded_as_packed(const DepthImage& depth);

}  // namespace rastro
