// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <filesystem>

#include "rastro/map/keyframe/rgbd_map.h"

namespace rastro {

/// Writes a finished map file and returns when it is on the disk.
void write_map(const RgbdMap& map, const std::filesystem::path& file);

/// Puts one file where another was, or where none was, in one step that outlasts a power cut.
void replace_file(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace rastro
