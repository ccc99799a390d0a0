// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace rastro::cli {

/// The map file that MAP names: a file, or the map.rastro of a run's folder.
inline std::filesystem::path map_file_of(const std::string& map) {
  std::error_code code;
  return std::filesystem::is_directory(map, code) ? std::filesystem::path(map) / "map.rastro"
                                                  : std::filesystem::path(map);
}

}  // namespace rastro::cli
