// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/map/landmark/landmark_map.h"

namespace rastro {

/// A map of landmarks from above, as .svg or .png: landmarks grey, pairs of keyframes that share at least `covisible`
/// landmarks light green, the essential graph green with what loop closing tied red, keyframes blue, the way dark from
/// S to E. Up is the mean of the cameras' up; the first camera looks to the top of the sheet. Submaps that nothing ties
/// to the first one are left out. Error naming the file where it is neither kind or cannot be written.
void write_landmark_picture(const LandmarkMap& map, const std::string& file, int covisible = 30);

}  // namespace rastro
