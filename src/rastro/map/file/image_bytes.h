// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <string>
#include <string_view>

#include "rastro/map/images/image_layer.h"

namespace rastro {

std::string body_of(const PackedPictures& pictures);
/// Error naming `where` for bytes that are not as they were written.
PackedPictures read_pictures(std::string_view body, const std::string& where);

}  // namespace rastro
