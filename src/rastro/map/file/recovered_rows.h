// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>

#include "rastro/base/error.h"
#include "rastro/map/file/bytes.h"
#include "rastro/map/file/contents.h"
#include "rastro/map/file/recover_map.h"

namespace rastro {

/// Every sound row of a file, by its number.
class RecoveredRows {
 public:
  using Rows = std::map<std::int64_t, std::string>;

  explicit RecoveredRows(std::string name) : file(std::move(name)) {}
  Rows& of(MapTable table) { return rows_[static_cast<std::size_t>(table)]; }

  /// How many rows the table of contents says each table of the kind should have; nullopt where it is lost or was never
  /// written.
  std::optional<std::array<std::int64_t, map_tables.size()>> counts(MapKind kind) {
    const auto row = of(MapTable::contents).find(contents_row);
    if (row == of(MapTable::contents).end()) return std::nullopt;
    std::array<std::int64_t, map_tables.size()> counts{};
    try {
      ByteReader bytes(row->second, file);
      for (const MapTable table : tables_of(kind)) {
        if (table == MapTable::contents) continue;
        bytes.text();
        counts[static_cast<std::size_t>(table)] = bytes.get<std::int64_t>();
        bytes.text();
      }
    } catch (const Error&) {
      return std::nullopt;
    }
    return counts;
  }

  const std::string file;

 private:
  std::array<Rows, map_tables.size()> rows_;
};

/// What a bad row costs is that row.
template <typename Read>
auto try_to(Read read) -> std::optional<decltype(read())> {
  try {
    return read();
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// Adds "2 of 6 edges" where not all were kept.
inline void say_lost(RecoveredMap& result, std::size_t kept, std::int64_t all, const char* what) {
  const std::int64_t lost = all - static_cast<std::int64_t>(kept);
  if (lost > 0) result.lost.push_back(fmt::format("{} of {} {}", lost, all, what));
}

/// The rows as a map of landmarks, whose head is among them.
RecoveredMap recover_landmark_map(RecoveredRows& rows);

}  // namespace rastro
