// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "rastro/synthetic/world.h"

namespace rastro {

// Both are in the frame of the recording's first camera: that of frame `first` of the world.

/// The lengths of a world for `rastro measure --objects`: names, true lengths, and rough points on their edges (x
/// right, y down, z forward), only as precise as a person would mark them: to 2 cm.
std::string objects_text(const World& world, std::int64_t first = 0);

/// All solids and panes of the world at that frame as triangles, with the mean colors of their faces: binary PLY. Round
/// solids have 48 sides. Returns the size; throws Error if it cannot be written.
std::uintmax_t write_ground_truth_mesh(const World& world, const std::filesystem::path& file, std::int64_t first = 0);

}  // namespace rastro
