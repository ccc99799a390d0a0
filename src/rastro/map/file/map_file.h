// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "rastro/map/graph/map.h"

namespace rastro {

/// Writes the map as one SQLite file whose bytes depend on the map alone: the same map gives the same file, and so does
/// one that was read from a file. Every row has a checksum, and a table of contents one over all rows. The file is put
/// in place whole: where writing fails, what was there before stays.
void save_map(const Map& map, const std::filesystem::path& file);

/// Reads a map file of this version or an older one; images are read from it when they are asked for, so the file must
/// stay. A file left by a run that was killed is taken as far as it goes. Error for a file that is no map, is of a
/// newer version, cut off or damaged.
std::shared_ptr<const Map> load_map(const std::filesystem::path& file);

/// Whether a file calls itself a map, sound or not.
bool is_map_file(const std::filesystem::path& file);

/// What was found when every byte of a map file that means something was read.
struct MapFileReport {
  std::uint32_t version = 0;
  std::uintmax_t bytes = 0;
  bool finished = false;           ///< False: the run that made it did not come to its end.
  std::string damage;              ///< One line; empty where all is sound.
  std::shared_ptr<const Map> map;  ///< Null where damaged.
};

/// Error only where the file is no map at all, or of a newer version.
MapFileReport check_map_file(const std::filesystem::path& file);

}  // namespace rastro
