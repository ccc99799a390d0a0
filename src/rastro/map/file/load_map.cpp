// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "rastro/base/error.h"
#include "rastro/map/file/bytes.h"
#include "rastro/map/file/contents.h"
#include "rastro/map/file/file_pictures.h"
#include "rastro/map/file/map_file.h"

namespace rastro {
namespace {

/// Hands the body of each row to `read`; the rows must be numbered without a gap.
template <typename Read>
void read_table(const Database& database, MapTable table, Read read) {
  std::int64_t next = 0;
  for (RowReader rows(database, table); rows.next(); ++next) {
    if (rows.id() != next) refuse_damaged(database.file(), fmt::format("lacks row {} of {}", next, name_of(table)));
    read(rows.body(), rows.id(), rows.where());
  }
}

std::optional<std::string> row_of(const Database& database, MapTable table, std::int64_t id) {
  RowReader rows(database, table, id);
  if (!rows.next() || rows.id() != id) return std::nullopt;
  return std::string(rows.body());
}

bool is_finished(const Database& database) {
  const auto contents = row_of(database, MapTable::contents, contents_row);
  if (contents && *contents != contents_body(database))
    refuse_damaged(database.file(), "does not hold what its table of contents says");
  return contents.has_value();
}

std::int64_t count_pictures(const Database& database) {
  std::int64_t count = 0;
  for (RowReader rows(database, MapTable::pictures, 0, RowReader::What::checksums); rows.next(); ++count)
    if (rows.id() != count) return -1;
  return count;
}

void check_consistency(RgbdMap& map, const Database& database, bool finished) {
  const auto keyframes = static_cast<std::int64_t>(map.keyframes.size());
  if (static_cast<std::int64_t>(map.poses.size()) != keyframes || count_pictures(database) != keyframes)
    refuse_damaged(database.file(), "does not have a pose and pictures for every keyframe");
  const auto dangles = [keyframes](const PoseEdge& edge) {
    return std::min(edge.from, edge.to) < 0 || std::max(edge.from, edge.to) >= keyframes;
  };
  // A run may be killed between an edge and the keyframe it leads to.
  const auto dangling = std::remove_if(map.edges.begin(), map.edges.end(), dangles);
  if (finished && dangling != map.edges.end())
    refuse_damaged(database.file(), "has an edge to a keyframe that is not there");
  map.edges.erase(dangling, map.edges.end());
}

struct Loaded {
  std::shared_ptr<RgbdMap> map = std::make_shared<RgbdMap>();
  bool finished = false;
};

Loaded load(const std::filesystem::path& file) {
  Loaded loaded;
  RgbdMap& map = *loaded.map;
  auto pictures = std::make_shared<FilePictures>();
  const Database& database = pictures->database.emplace(Database::open(file));
  loaded.finished = is_finished(database);
  const auto head = row_of(database, MapTable::head, 0);
  if (!head) refuse_damaged(database.file());
  read_head(*head, database.file(), map);
  read_table(database, MapTable::keyframes, [&](std::string_view body, std::int64_t id, const std::string& where) {
    map.keyframes.push_back(read_keyframe(body, id, where));
  });
  read_table(database, MapTable::poses, [&](std::string_view body, std::int64_t, const std::string& where) {
    map.poses.push_back(read_pose(body, where));
  });
  read_table(database, MapTable::edges, [&](std::string_view body, std::int64_t, const std::string& where) {
    map.edges.push_back(read_edge(body, where));
  });
  read_table(database, MapTable::way, [&](std::string_view body, std::int64_t, const std::string& where) {
    map.trajectory.push_back(read_stamped_pose(body, where));
  });
  check_consistency(map, database, loaded.finished);
  map.pictures = std::move(pictures);
  return loaded;
}

}  // namespace

std::shared_ptr<const RgbdMap> load_map(const std::filesystem::path& file) { return load(file).map; }

bool is_map_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  char header[72] = {};
  return stream.read(header, sizeof header) && std::string_view(header + 68, 4) == "RSTR" &&
         std::string_view(header, 15) == "SQLite format 3";
}

MapFileReport check_map_file(const std::filesystem::path& file) {
  MapFileReport report;
  report.version = map_file_version;
  std::error_code code;
  report.bytes = std::filesystem::file_size(file, code);
  if (!is_map_file(file)) load(file);  // says what is wrong
  try {
    const Loaded loaded = load(file);
    report.finished = loaded.finished;
    for (const auto& keyframe : loaded.map->keyframes) loaded.map->pictures->pictures(keyframe->id);
    report.map = loaded.map;
  } catch (const Error& error) {
    report.damage = error.what();
  }
  return report;
}

}  // namespace rastro
