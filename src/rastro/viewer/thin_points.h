// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace rastro {

/// Indices, ascending, of at most `most` of the points (x y z each) with finite positions: the first one of each cube
/// of a raster whose side is `side` at least, and larger where that leaves too many. So the points that stay are spread
/// evenly. side >= 0; 0: all points, where they are no more than `most`. The same for the same points.
std::vector<std::uint32_t> thin_points(std::span<const float> positions, double side, std::size_t most);

}  // namespace rastro
