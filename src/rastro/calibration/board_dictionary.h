// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace rastro {

/// OpenCV's number of a predefined dictionary of tags ("4x4_50", "36h11"); nullopt for other names.
std::optional<int> dictionary_number(std::string_view name);
/// How many tags it has; 0 for other names.
int dictionary_size(std::string_view name);
/// "16h5", "25h9", "36h10", "36h11" (Olson 2011, "AprilTag: A robust and flexible visual fiducial system").
bool is_apriltag_family(std::string_view name);

/// Cells of a tag with a border of one cell, row by row; true is black. The tag must exist.
std::vector<std::vector<bool>> tag_cells(std::string_view name, int id);

}  // namespace rastro
