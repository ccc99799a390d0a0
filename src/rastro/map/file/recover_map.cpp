// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/recover_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "rastro/base/error.h"
#include "rastro/map/file/bytes.h"
#include "rastro/map/file/carve.h"
#include "rastro/map/file/contents.h"
#include "rastro/map/file/graph_rows.h"
#include "rastro/map/file/read_map.h"

namespace rastro {
namespace {

/// All tables of a file of any version that this program knows.
std::vector<std::string> known_tables() {
  std::set<std::string> tables;
  for (const std::uint32_t version : {1U, 2U, 3U})
    for (const char* table : tables_of_version(version)) tables.insert(table);
  for (const auto& type : layer_types()) tables.insert(table_of_layer(type->name()));
  return {tables.begin(), tables.end()};
}

std::optional<std::uint32_t> version_of(FoundRows& rows) {
  for (const auto& [table, id] : {std::pair("head", std::int64_t{0}), std::pair("contents", second_head_row)}) {
    const auto row = rows.of(table).find(id);
    if (row == rows.of(table).end()) continue;
    return is_layered_head(row->second) ? 3U : is_landmark_head(row->second) ? 2U : 1U;
  }
  return std::nullopt;
}

/// Number of rows of each table by the table of contents; nullopt if it is lost or was never written.
std::optional<std::map<std::string, std::int64_t>> counts_in(FoundRows& rows) {
  const auto row = rows.of("contents").find(contents_row);
  if (row == rows.of("contents").end()) return std::nullopt;
  std::map<std::string, std::int64_t> counts;
  try {
    ByteReader bytes(row->second, rows.file());
    while (bytes.left() > 0) {
      const std::string table(bytes.text());
      counts[table] = bytes.get<std::int64_t>();
      bytes.text();
    }
  } catch (const Error&) {
    return std::nullopt;
  }
  return counts;
}

/// Human-readable name of a table's items.
std::string items_of(const std::string& table) {
  constexpr std::string_view prefix = "layer_";
  if (table == "poses") return "poses of keyframes";
  if (table == "way") return "frames";
  if (table == "edges" || table == "ties") return "constraints";
  return table.starts_with(prefix) ? table.substr(prefix.size()) : table;
}

std::vector<std::string> lost_of(FoundRows& rows, std::uint32_t version,
                                 const std::optional<std::map<std::string, std::int64_t>>& counts) {
  std::vector<std::string> tables;
  for (const char* table : tables_of_version(version))
    if (std::string_view(table) != "contents" && std::string_view(table) != "head") tables.emplace_back(table);
  for (const auto& type : layer_types())
    if (version >= 3) tables.push_back(table_of_layer(type->name()));
  std::vector<std::string> lost;
  // Counted by the contents alone, since this program cannot read them.
  if (counts)
    for (const auto& [table, rows_in_table] : *counts)
      if (table.starts_with("layer_") && std::find(tables.begin(), tables.end(), table) == tables.end())
        lost.push_back(fmt::format("the layer {}, which this program does not know", items_of(table)));
  for (const std::string& table : tables) {
    const auto found = static_cast<std::int64_t>(rows.of(table).size()) - rows.refused(table);
    std::int64_t wanted = found + rows.refused(table);
    if (counts && counts->contains(table)) wanted = counts->at(table);
    // Keyframes and lists are numbered: gaps show what is lost even without the contents.
    const bool numbered = version == 1 || table == "frames" || table == "constraints" || table == "way";
    if (!counts && numbered && !rows.of(table).empty())
      wanted = std::clamp<std::int64_t>(rows.of(table).rbegin()->first + 1, wanted, std::int64_t{1} << 30);
    if (wanted > found) lost.push_back(fmt::format("{} of {} {}", wanted - found, wanted, items_of(table)));
  }
  return lost;
}

/// Rows are found by the names of their tables: those of unknown layers are not.
void drop_empty_unknown_layers(Map& map) {
  const LayerSet::Layers layers = map.layers.all();
  for (const auto& [name, layer] : layers)
    if (!layer_type(name)) map.layers.put(name, nullptr);
}

}  // namespace

RecoveredMap recover_map(const std::filesystem::path& file) {
  FoundRows rows(file.string());
  carve_rows(file, known_tables(),
             [&](const std::string& table, std::int64_t id, const std::string& body) { rows.of(table)[id] = body; });
  const auto version = version_of(rows);
  if (!version)
    throw Error("nothing of a map was found", rows.file(), "give the map.rastro of a run; this one is beyond saving");
  const std::shared_ptr<Map> map = read_map(rows, *version);
  const std::size_t frames = map->frames.size();
  const std::size_t invalid = std::erase_if(map->constraints, [](const auto& each) { return !fault_of(each).empty(); });
  const std::size_t constraints = map->constraints.size();
  repair(*map);
  const std::string fault = contradiction_in(*map);
  if (!fault.empty()) throw Error(fault, rows.file(), "this one is beyond saving");
  drop_empty_unknown_layers(*map);
  RecoveredMap result;
  const auto counts = counts_in(rows);
  result.finished = counts.has_value();
  result.lost = lost_of(rows, *version, counts);
  if (invalid > 0) result.lost.push_back(fmt::format("{} constraints that cannot be optimized", invalid));
  if (map->constraints.size() < constraints)
    result.lost.push_back(fmt::format("{} constraints of lost keyframes", constraints - map->constraints.size()));
  if (map->frames.size() < frames)
    result.lost.push_back(fmt::format("{} frames of lost keyframes", frames - map->frames.size()));
  result.map = map;
  return result;
}

}  // namespace rastro
