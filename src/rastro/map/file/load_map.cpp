// SPDX-License-Identifier: Apache-2.0
#include <fstream>

#include "rastro/base/error.h"
#include "rastro/map/file/bytes.h"
#include "rastro/map/file/contents.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/file/read_map.h"
#include "rastro/map/layer_type.h"

namespace rastro {
namespace {

struct Loaded {
  std::shared_ptr<const Map> map;
  bool finished = false;
};

Loaded load(const std::filesystem::path& file) {
  auto shared = std::make_shared<SharedDatabase>();
  const Database& database = shared->database.emplace(Database::open(file));
  Loaded loaded;
  loaded.finished = is_finished(database);
  SoundRows rows(shared);
  const std::shared_ptr<Map> map = read_map(rows, database.version());
  // A run may be killed between a constraint and its keyframe.
  if (!loaded.finished) repair(*map);
  const std::string fault = contradiction_in(*map);
  if (!fault.empty()) refuse_damaged(file.string(), fault);
  loaded.map = map;
  return loaded;
}

/// Of the layers that stay in the file.
void read_every_row(const Map& map) {
  for (const auto& [name, layer] : map.layers.all()) {
    const LayerType* type = layer_type(name);
    if (!type || !type->stays_in_file()) continue;
    for (const std::int64_t id : type->rows(*layer)) type->row(*layer, id);
  }
}

}  // namespace

std::shared_ptr<const Map> load_map(const std::filesystem::path& file) { return load(file).map; }

bool is_map_file(const std::filesystem::path& file) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(file, code)) return false;
  std::ifstream stream(file, std::ios::binary);
  char header[72] = {};
  return stream.read(header, sizeof header) && std::string_view(header + 68, 4) == "RSTR" &&
         std::string_view(header, 15) == "SQLite format 3";
}

MapFileReport check_map_file(const std::filesystem::path& file) {
  MapFileReport report;
  std::error_code code;
  report.bytes = std::filesystem::file_size(file, code);
  const std::uintmax_t log_bytes = std::filesystem::file_size(file.string() + "-wal", code);
  if (!code) report.log_bytes = log_bytes;
  if (!is_map_file(file)) load(file);  // throws with the reason
  try {
    report.version = Database::open(file).version();
    const Loaded loaded = load(file);
    report.finished = loaded.finished;
    read_every_row(*loaded.map);
    report.map = loaded.map;
  } catch (const Error& error) {
    report.damage = error.what();
  }
  return report;
}

}  // namespace rastro
