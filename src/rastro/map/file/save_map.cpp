// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/save_map.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "rastro/base/error.h"
#include "rastro/map/file/contents.h"
#include "rastro/map/file/landmark_tables.h"
#include "rastro/map/file/map_file.h"

namespace rastro {
namespace {

void sync_to_disk(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return;  // a folder that may not be read: the system writes it when it likes
  const bool failed = ::fsync(descriptor) != 0 && errno != EINVAL;
  const int reason = errno;
  ::close(descriptor);
  if (failed)
    throw Error(std::string("cannot be written (") + std::strerror(reason) + ")", path.string(), "check the disk");
}

void write_tables(const RgbdMap& map, Database& database) {
  const std::string head = head_body(map);
  database.put(MapTable::head, 0, head);
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    const auto id = static_cast<std::int64_t>(i);
    RASTRO_CHECK(map.keyframes[i]->id == id, "keyframes are numbered in their order");
    database.put(MapTable::keyframes, id, body_of(*map.keyframes[i]));
    database.put(MapTable::pictures, id, body_of(map.pictures->pictures(id)));
    database.put(MapTable::poses, id, body_of(map.poses[i]));
  }
  for (std::size_t i = 0; i < map.edges.size(); ++i)
    database.put(MapTable::edges, static_cast<std::int64_t>(i), body_of(map.edges[i]));
  for (std::size_t i = 0; i < map.trajectory.size(); ++i)
    database.put(MapTable::way, static_cast<std::int64_t>(i), body_of(map.trajectory[i]));
  database.put(MapTable::contents, contents_row, contents_body(database));
  database.put(MapTable::contents, second_head_row, head);
}

}  // namespace

void write_map(const RgbdMap& map, const std::filesystem::path& file) {
  RASTRO_CHECK(map.poses.size() == map.keyframes.size(), "every keyframe has a pose");
  RASTRO_CHECK(map.keyframes.empty() || map.pictures, "every keyframe has pictures");
  {
    Database database = Database::create(file);
    database.run("BEGIN");
    write_tables(map, database);
    database.run("COMMIT");
  }
  sync_to_disk(file);
}

void write_map(const LandmarkMap& map, const std::filesystem::path& file) {
  {
    Database database = Database::create(file, MapKind::landmarks);
    database.run("BEGIN");
    write_changes(nullptr, map, database);
    database.put(MapTable::contents, contents_row, contents_body(database));
    database.run("COMMIT");
  }
  sync_to_disk(file);
}

void replace_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::error_code code;
  std::filesystem::rename(from, to, code);
  if (code) {
    std::error_code ignored;
    std::filesystem::remove(from, ignored);
    throw Error("cannot be put in place (" + code.message() + ")", to.string(), "choose another file");
  }
  sync_to_disk(to.has_parent_path() ? to.parent_path() : std::filesystem::path("."));
}

void save_map(const RgbdMap& map, const std::filesystem::path& file) {
  replace_file(write_map_beside(map, file), file);
}

void save_map(const LandmarkMap& map, const std::filesystem::path& file) {
  replace_file(write_map_beside(map, file), file);
}

}  // namespace rastro
