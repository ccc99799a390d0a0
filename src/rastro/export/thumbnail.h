// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/sensor/frame.h"

namespace rastro {

/// A small JPEG for a page that holds its images itself: "data:image/jpeg;base64,...", with sides of at most
/// `side_px`. Transparent parts become white. Empty where the file is no image that can be read.
std::string thumbnail_of(const std::string& image_file, int side_px);
/// The same of the color image of a frame, or the gray one; empty where it has none.
std::string thumbnail_of(const Frame& frame, int side_px);

/// RFC 4648, with padding.
std::string as_base64(const std::string& bytes);

}  // namespace rastro
