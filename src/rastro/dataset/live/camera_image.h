// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstddef>
#include <span>

#include "rastro/dataset/live/y4m.h"
#include "rastro/sensor/frame.h"

namespace rastro {

// Images as cameras give them, to those of a frame: gray, and color where it is wanted. Gray is the luma where no color
// is wanted, else made from the color, so that a recording of the color gives the same gray.

/// Error where it cannot be decoded.
void decode_jpeg(std::span<const unsigned char> file, bool want_color, Frame& frame);
/// `planes` has header.frame_bytes() bytes.
void convert_y4m(const Y4mHeader& header, std::span<const unsigned char> planes, bool want_color, Frame& frame);
/// Rows of `stride` bytes; the caller has checked that there are enough of them.
void convert_yuyv(const unsigned char* bytes, int width, int height, std::size_t stride, bool want_color, Frame& frame);
void convert_grey(const unsigned char* bytes, int width, int height, std::size_t stride, bool want_color, Frame& frame);
/// Red first.
void convert_rgb(const unsigned char* bytes, int width, int height, std::size_t stride, bool want_color, Frame& frame);

}  // namespace rastro
