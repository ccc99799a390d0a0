// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "rastro/base/error.h"
#include "rastro/map/file/bytes.h"
#include "rastro/map/file/contents.h"
#include "rastro/map/file/file_pictures.h"
#include "rastro/map/file/landmark_tables.h"
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

[[noreturn]] void refuse_kind(const Database& database) {
  if (database.kind() == MapKind::landmarks)
    throw Error("is a map of landmarks, and one of a depth camera is needed", database.file(),
                "'rastro slam DATA --method rgbd' makes those");
  throw Error("is a map of a depth camera, and one of landmarks is needed", database.file(),
              "'rastro slam DATA --method orb' makes those");
}

RgbdMap read_rgbd_map(const Database& database) {
  RgbdMap map;
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
  return map;
}

/// A file of either kind.
struct Loaded {
  std::shared_ptr<const RgbdMap> map;
  std::shared_ptr<const LandmarkMap> landmark_map;
  bool finished = false;
  std::uint32_t version = 0;
};

Loaded load(const std::filesystem::path& file, std::optional<MapKind> wanted = std::nullopt) {
  auto pictures = std::make_shared<FilePictures>();
  const Database& database = pictures->database.emplace(Database::open(file));
  if (wanted && *wanted != database.kind()) refuse_kind(database);
  Loaded loaded;
  loaded.version = version_of(database.kind());
  loaded.finished = is_finished(database);
  if (database.kind() == MapKind::landmarks) {
    loaded.landmark_map = std::make_shared<LandmarkMap>(read_landmark_map(database));
    return loaded;
  }
  const auto map = std::make_shared<RgbdMap>(read_rgbd_map(database));
  check_consistency(*map, database, loaded.finished);
  map->pictures = std::move(pictures);
  loaded.map = map;
  return loaded;
}

}  // namespace

std::shared_ptr<const RgbdMap> load_map(const std::filesystem::path& file) { return load(file, MapKind::rgbd).map; }

std::shared_ptr<const LandmarkMap> load_landmark_map(const std::filesystem::path& file) {
  return load(file, MapKind::landmarks).landmark_map;
}

MapKind kind_of_map(const std::filesystem::path& file) { return Database::open(file).kind(); }

bool is_map_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  char header[72] = {};
  return stream.read(header, sizeof header) && std::string_view(header + 68, 4) == "RSTR" &&
         std::string_view(header, 15) == "SQLite format 3";
}

MapFileReport check_map_file(const std::filesystem::path& file) {
  MapFileReport report;
  std::error_code code;
  report.bytes = std::filesystem::file_size(file, code);
  if (!is_map_file(file)) load(file);  // says what is wrong
  try {
    const Loaded loaded = load(file);
    report.version = loaded.version;
    report.finished = loaded.finished;
    if (loaded.map)
      for (const auto& keyframe : loaded.map->keyframes) loaded.map->pictures->pictures(keyframe->id);
    report.map = loaded.map;
    report.landmark_map = loaded.landmark_map;
  } catch (const Error& error) {
    report.damage = error.what();
  }
  return report;
}

}  // namespace rastro
