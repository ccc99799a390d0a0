// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/map/images/image_layer.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// The color image (the gray one where there is none) and the depth of a frame, packed. The same bytes for the same
/// pixels. Depth beyond 13.1 m does not fit 16 bits and is left out.
PackedImages pack_images(const Frame& frame);
/// Without packed depth, the depth is 0 everywhere. Error (naming `where`) for bytes that are not such images, or
/// images of different sizes.
UnpackedImages unpack_images(const PackedImages& images, const std::string& where);

/// The color image alone, in gray, `shrink` (1, 2, 4 or 8) times smaller, which takes a fraction of the time. Error as
/// above, for the color's bytes.
GrayImage unpack_gray(const PackedImages& images, int shrink, const std::string& where);

/// The depth alone, without the time that the color image takes. Error as above, for the depth's bytes.
DepthImage unpack_depth(const PackedImages& images, const std::string& where);

/// Images in memory.
using MemoryImages = MemoryItems<PackedImages>;

}  // namespace rastro
