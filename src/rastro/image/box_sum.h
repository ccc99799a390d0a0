// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/image/padded_image.h"

namespace rastro {

/// sums(x, y) = sum of the (2 radius + 1)^2 pixels around (x, y), reading the padding outside. 0 <= radius <= 7, so
/// that a sum fits 16 bits. `sums` gets the image's size (its memory is kept when that is the same).
void box_sums(const PaddedImage& image, int radius, Image<std::uint16_t>& sums);

}  // namespace rastro
