// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/viewer/scene.h"

namespace rastro {

/// The block of bytes that the page reads: the length of the header (32 bits, little endian), the header as JSON,
/// padded with spaces to a multiple of 8 bytes, then the arrays that the header refers to by offset, type and count.
/// The same bytes for the same scene. README.md has the format.
std::string scene_bytes(const ViewScene& scene);

}  // namespace rastro
