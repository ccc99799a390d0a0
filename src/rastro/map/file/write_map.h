// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <filesystem>

#include "rastro/map/file/database.h"
#include "rastro/map/graph/map.h"

namespace rastro {

/// Which layers are written.
enum class LayersWritten { all, without_those_that_stay_in_file };

/// Makes the tables, which hold `before` (null: nothing), hold `now`; writes what differs and nothing else.
void write_changes(const Map* before, const Map& now, LayersWritten layers, Database& database);

/// Writes a finished map beside `file`, under a name that is given back, and returns when it is on the disk; where it
/// fails nothing is left.
std::filesystem::path write_map_beside(const Map& map, const std::filesystem::path& file);

/// Puts one file where another was, or where none was, in one step that outlasts a power cut. Where it cannot, `from`
/// is gone.
void replace_file(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace rastro
