// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <filesystem>
#include <system_error>

#include "rastro/map/keyframe/rgbd_map.h"
#include "rastro/map/landmark/landmark_map.h"

namespace rastro {

/// Writes a finished map file and returns when it is on the disk.
void write_map(const RgbdMap& map, const std::filesystem::path& file);
void write_map(const LandmarkMap& map, const std::filesystem::path& file);

/// The same beside `file`, under a name that is given back; where it fails nothing is left.
template <typename Map>
std::filesystem::path write_map_beside(const Map& map, const std::filesystem::path& file) {
  const std::filesystem::path aside = file.string() + ".new";
  try {
    write_map(map, aside);
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(aside, ignored);
    throw;
  }
  return aside;
}

/// Puts one file where another was, or where none was, in one step that outlasts a power cut. Where it cannot, `from`
/// is gone.
void replace_file(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace rastro
