// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "rastro/map/graph/map.h"

namespace rastro {

/// Writes the map as one SQLite file whose bytes depend on the map alone: the same map gives the same file, also after
/// it was read from a file. Every row has a checksum, and a table of contents has one over all rows. The file is
/// replaced atomically: if writing fails, the previous one stays.
void save_map(const Map& map, const std::filesystem::path& file);

/// Reads a map file of this version or an older one. Images are read from it on demand, so the file must stay. A file
/// left by a killed run is read as far as it goes. Error for a file that is no map, has a newer version, is truncated
/// or damaged.
std::shared_ptr<const Map> load_map(const std::filesystem::path& file);

/// Whether a file has the application id of a map, valid or not.
bool is_map_file(const std::filesystem::path& file);

/// The result of a check of every meaningful byte of a map file.
struct MapFileReport {
  std::uint32_t version = 0;
  std::uintmax_t bytes = 0;
  std::uintmax_t log_bytes = 0;    ///< Of FILE-wal beside it, which a killed run leaves: a part of the map.
  bool finished = false;           ///< False: the run that made it did not finish.
  std::string damage;              ///< One line; empty if there is none.
  std::shared_ptr<const Map> map;  ///< Null if damaged.
};

/// Error only if the file is no map at all, or has a newer version.
MapFileReport check_map_file(const std::filesystem::path& file);

}  // namespace rastro
