// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "rastro/map/file/database.h"
#include "rastro/map/graph/map.h"

namespace rastro {

/// Which layers are written.
enum class LayersWritten { all, without_those_that_stay_in_file };

/// What is in the tables, to be compared with the next map: hashes instead of rows, since the poses of frames become
/// more with time, not only with places.
struct WrittenMap {
  struct Row {
    std::int64_t id;
    std::size_t hash;
  };
  std::string head;
  std::map<std::string, std::vector<Row>> tables;            ///< Of the pose graph; ids ascend.
  std::map<std::string, std::vector<std::size_t>> numbered;  ///< The same, of rows counted from 0: their hashes alone.
  LayerSet layers;
};

/// Updates the tables from `written` (empty: they are empty or missing) to `now`, whose sessions are written as
/// `sessions`; writes only the differences, and notes them in `written`, which is useless after an Error.
void write_changes(const Map& now, const std::vector<MapSession>& sessions, LayersWritten layers, WrittenMap& written,
                   Database& database);

/// Writes a finished map next to `file`, under the returned name, and returns when it is on disk; on failure nothing is
/// left.
std::filesystem::path write_map_beside(const Map& map, const std::filesystem::path& file);

/// Atomically replaces a map file by another, or creates it, safe against a power failure; the log of the former file
/// goes with it, so what is in it must have been read before. On failure, `from` is removed.
void replace_file(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace rastro
