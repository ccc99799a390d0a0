// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <filesystem>

#include "rastro/map/file/database.h"
#include "rastro/map/graph/map.h"

namespace rastro {

/// Which layers are written.
enum class LayersWritten { all, without_those_that_stay_in_file };

/// Updates the tables from `before` (null: they are empty or missing) to `now`; writes only the differences.
void write_changes(const Map* before, const Map& now, LayersWritten layers, Database& database);

/// Writes a finished map next to `file`, under the returned name, and returns when it is on disk; on failure nothing is
/// left.
std::filesystem::path write_map_beside(const Map& map, const std::filesystem::path& file);

/// Atomically replaces a map file by another, or creates it, safe against a power failure; the log of the former file
/// goes with it, so what is in it must have been read before. On failure, `from` is removed.
void replace_file(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace rastro
