// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/write_map.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <functional>
#include <system_error>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/map/file/bytes.h"
#include "rastro/map/file/contents.h"
#include "rastro/map/file/graph_rows.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/layer_type.h"

namespace rastro {
namespace {

void sync_to_disk(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return;  // an unreadable folder: the system writes it at its own time
  const bool failed = ::fsync(descriptor) != 0 && errno != EINVAL;
  const int reason = errno;
  ::close(descriptor);
  if (failed)
    throw Error(std::string("cannot be written (") + std::strerror(reason) + ")", path.string(), "check the disk");
}

/// SQLite would overlay the rows of a log onto whatever file has its name. It is left by a killed run, and by a run
/// during which another process had the map open; such a process keeps reading what it opened.
void remove_log(const std::filesystem::path& file) {
  for (const char* ending : {"-wal", "-shm"}) {
    std::error_code ignored;
    std::filesystem::remove(file.string() + ending, ignored);
  }
}

/// Compares two ascending lists of ids: removed ones, and current ones, new or not.
template <typename Gone, typename There>
void compare_ids(const std::vector<std::int64_t>& before, const std::vector<std::int64_t>& now, Gone gone,
                 There there) {
  std::size_t b = 0;
  for (const std::int64_t id : now) {
    for (; b < before.size() && before[b] < id; ++b) gone(before[b]);
    const bool known = b < before.size() && before[b] == id;
    there(id, known);
    if (known) ++b;
  }
  for (; b < before.size(); ++b) gone(before[b]);
}

/// Rows named by an ascending id. What is known of them is changed where it is: a second list would be as long as a
/// run.
template <typename Item, typename IdOf>
void write_list(const std::string& table, const std::vector<Item>& items, const IdOf& id_of, WrittenMap& written,
                Database& database) {
  std::vector<WrittenMap::Row>& rows = written.tables[table];
  auto next = rows.begin();  // the rows before are those of the items so far
  const auto remove_until = [&](auto is_past) {
    auto end = next;
    for (; end != rows.end() && !is_past(end->id); ++end) database.remove(table, end->id);
    next = rows.erase(next, end);
  };
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::int64_t id = id_of(i);
    const std::string body = body_of(items[i]);
    const std::size_t hash = std::hash<std::string>()(body);
    remove_until([id](std::int64_t other) { return other >= id; });
    const bool known = next != rows.end() && next->id == id;
    if (!known || next->hash != hash) database.put(table, id, body);
    if (!known) next = rows.insert(next, {id, hash});
    next->hash = hash;
    ++next;
  }
  remove_until([](std::int64_t) { return false; });
}

/// Rows counted from 0.
template <typename Item>
void write_numbered(const std::string& table, const std::vector<Item>& items, WrittenMap& written, Database& database) {
  std::vector<std::size_t>& hashes = written.numbered[table];
  const std::size_t before = hashes.size();
  for (std::size_t i = items.size(); i < before; ++i) database.remove(table, static_cast<std::int64_t>(i));
  // An eighth more: doubling takes twice the memory.
  if (items.size() > hashes.capacity()) hashes.reserve(items.size() + items.size() / 8);
  hashes.resize(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::string body = body_of(items[i]);
    const std::size_t hash = std::hash<std::string>()(body);
    if (i >= before || hashes[i] != hash) database.put(table, static_cast<std::int64_t>(i), body);
    hashes[i] = hash;
  }
}

void write_unknown(const std::string& table, const UnknownLayer& layer, Database& database) {
  database.clear(table);
  for (const auto& [id, body] : layer.rows) database.put(table, id, body);
}

void write_rows(const LayerType& type, const LayerSet& before, const LayerSet& now, Database& database) {
  const std::string table = table_of_layer(type.name());
  const auto former = before.find(type.name()), layer = now.find(type.name());
  if (former == layer) return;
  const auto ids = former ? type.rows(*former) : std::vector<std::int64_t>{};
  compare_ids(
      ids, type.rows(*layer), [&](std::int64_t id) { database.remove(table, id); },
      [&](std::int64_t id, bool known) {
        if (!known || !type.same_row(*former, *layer, id)) database.put(table, id, type.row(*layer, id));
      });
}

std::string layer_body(const std::string& name, const Layer& layer) {
  const LayerType* type = layer_type(name);
  const auto* unknown = dynamic_cast<const UnknownLayer*>(&layer);
  ByteWriter bytes;
  bytes.put_text(name);
  bytes.put_text(unknown ? unknown->header : type ? type->header(layer) : std::string());
  return bytes.take();
}

void write_layers(const LayerSet& before, const LayerSet& now, LayersWritten which, Database& database) {
  std::vector<std::string> listed, listed_before;
  for (const auto& [name, layer] : before.all()) listed_before.push_back(layer_body(name, *layer));
  for (const auto& [name, layer] : now.all()) {
    const std::string table = table_of_layer(name);
    database.need_table(table);
    listed.push_back(layer_body(name, *layer));
    const LayerType* type = layer_type(name);
    if (const auto* unknown = dynamic_cast<const UnknownLayer*>(layer.get())) {
      if (before.find(name) != layer) write_unknown(table, *unknown, database);
    } else if (type && (which == LayersWritten::all || !type->stays_in_file())) {
      write_rows(*type, before, now, database);
    }
  }
  for (const auto& [name, layer] : before.all())
    if (!now.find(name)) database.clear(table_of_layer(name));
  for (std::size_t i = 0; i < listed.size(); ++i)
    if (i >= listed_before.size() || listed_before[i] != listed[i])
      database.put("layers", static_cast<std::int64_t>(i), listed[i]);
  for (std::size_t i = listed.size(); i < listed_before.size(); ++i)
    database.remove("layers", static_cast<std::int64_t>(i));
}

void write_map(const Map& map, const std::filesystem::path& file) {
  {
    Database database = Database::create(file);
    database.run("BEGIN");
    WrittenMap written;
    write_changes(map, map.sessions, LayersWritten::all, written, database);
    database.put("contents", contents_row, contents_body(database));
    database.run("COMMIT");
  }
  sync_to_disk(file);
}

}  // namespace

void write_changes(const Map& now, const std::vector<MapSession>& sessions, LayersWritten layers, WrittenMap& written,
                   Database& database) {
  const std::string head = head_body(now);
  if (written.head != head) {
    database.put("head", 0, head);
    database.put("contents", second_head_row, head);
    written.head = head;
  }
  write_numbered("cameras", now.cameras, written, database);
  write_numbered("sessions", sessions, written, database);
  write_list(
      "keyframes", now.keyframes, [&](std::size_t i) { return now.keyframes[i].id; }, written, database);
  write_numbered("constraints", now.constraints, written, database);
  write_numbered("frames", now.frames, written, database);
  write_layers(written.layers, now.layers, layers, database);
  written.layers = now.layers;
}

std::filesystem::path write_map_beside(const Map& map, const std::filesystem::path& file) {
  const std::filesystem::path aside = file.string() + ".new";
  try {
    write_map(map, aside);
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(aside, ignored);
    throw;
  }
  return aside;
}

void replace_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::error_code code, ignored;
  // Before, so that a crash in between leaves no log beside the new file; after, for a process that opened the former
  // file meanwhile.
  if (!std::filesystem::is_directory(to, ignored)) remove_log(to);
  std::filesystem::rename(from, to, code);
  if (code) {
    std::filesystem::remove(from, ignored);
    throw Error("cannot be put in place (" + code.message() + ")", to.string(), "choose another file");
  }
  remove_log(to);
  sync_to_disk(to.has_parent_path() ? to.parent_path() : std::filesystem::path("."));
}

void save_map(const Map& map, const std::filesystem::path& file) { replace_file(write_map_beside(map, file), file); }

}  // namespace rastro
