// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <string>
#include <string_view>

#include "rastro/map/images/image_layer.h"

namespace rastro {

std::string body_of(const PackedImages& images);
/// Error naming `where` for invalid bytes.
PackedImages read_images(std::string_view body, const std::string& where);

}  // namespace rastro
