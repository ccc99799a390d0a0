// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "rastro/viewer/point_tiles.h"

namespace rastro::cli {

/// What `rastro view` shows of a PLY file: its points, at most `most` of them, evenly spread, in tiles where they are
/// many. Up is z, but in clouds that rastro wrote in the frame of a camera. Error for a file that is none or has no
/// points.
NamedScene cloud_scene(const std::string& path, std::size_t most, const TileProgress& tiling);

}  // namespace rastro::cli
