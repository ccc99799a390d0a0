// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/map/graph/map.h"

namespace rastro {

/// Landmarks and keyframes from above, as .svg or .png: landmarks gray, pairs of keyframes that share at least
/// `covisible` landmarks light green, the essential graph green with loop closures and merges red, keyframes blue, the
/// trajectory dark from S to E. Up is the mean of the cameras' up; the first camera looks to the top of the sheet.
/// Disconnected submaps are omitted. Error naming the file where it is neither kind or cannot be written.
void write_landmark_image(const Map& map, const std::string& file, int covisible = 30);

}  // namespace rastro
