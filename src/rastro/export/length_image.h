// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "rastro/image/image.h"

namespace rastro {

/// Writes the part of an image around some lines as a PNG, enlarged, the lines drawn into it and a caption above.
/// Lines are given by their ends, pixels; those that are not finite are omitted, and those of no length are drawn as
/// crosses. Error naming the file when it cannot be written.
void write_length_image(const ColorImage& image, const std::vector<std::array<Eigen::Vector2d, 2>>& lines,
                        const std::string& caption, const std::string& file);

}  // namespace rastro
