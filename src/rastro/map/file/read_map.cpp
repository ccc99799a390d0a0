// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/read_map.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/map/file/bytes.h"
#include "rastro/map/file/contents.h"
#include "rastro/map/file/graph_rows.h"

namespace rastro {
namespace {

struct NamedHeader {
  std::string name, header;
};

std::vector<NamedHeader> layers_in(RowSource& rows) {
  std::vector<NamedHeader> layers;
  rows.each("layers", [&](std::string_view body, std::int64_t, const std::string& where) {
    ByteReader bytes(body, where);
    NamedHeader& layer = layers.emplace_back();
    layer.name = bytes.text();
    layer.header = bytes.text();
    bytes.finish();
  });
  return layers;
}

std::shared_ptr<const Layer> unknown_layer(RowSource& rows, const std::string& table, const std::string& header) {
  auto layer = std::make_shared<UnknownLayer>();
  layer->header = header;
  rows.each(table, [&](std::string_view body, std::int64_t id, const std::string&) {
    layer->rows.emplace_back(id, std::string(body));
  });
  return layer;
}

std::shared_ptr<const Layer> layer_in(RowSource& rows, const NamedHeader& named) {
  const std::string table = table_of_layer(named.name);
  const LayerType* type = layer_type(named.name);
  if (!type) return unknown_layer(rows, table, named.header);
  const std::shared_ptr<Layer> layer = type->make(named.header, rows.file());
  const auto stored = type->stays_in_file() ? rows.stored(table) : nullptr;
  if (stored) {
    rows.each_id(table, [&](std::int64_t id) { type->read(*layer, id, {}, rows.file()); });
    type->attach(*layer, stored);
  } else {
    rows.each(table, [&](std::string_view body, std::int64_t id, const std::string& where) {
      type->read(*layer, id, body, where);
    });
  }
  return layer;
}

/// Rows of a list are numbered without gaps.
void check_number(std::int64_t id, std::size_t count, const char* table, const std::string& where) {
  if (id != static_cast<std::int64_t>(count))
    refuse_damaged(where, fmt::format("stands where row {} of {} should be", count, table));
}

template <typename Item, typename ReadBody>
void read_list(RowSource& rows, const char* table, std::vector<Item>& list, ReadBody read_body) {
  const bool sound = rows.stored(table) != nullptr;
  rows.each(table, [&](std::string_view body, std::int64_t id, const std::string& where) {
    if (sound) check_number(id, list.size(), table, where);
    list.push_back(read_body(body, where));
  });
}

/// Keyframes refer to cameras by index: after a lost camera the following ones cannot be kept at theirs.
void read_cameras(RowSource& rows, std::vector<MapCamera>& cameras) {
  rows.each("cameras", [&](std::string_view body, std::int64_t id, const std::string& where) {
    check_number(id, cameras.size(), "cameras", where);
    cameras.push_back(read_camera(body, where));
  });
}

std::shared_ptr<Map> read_layered_map(RowSource& rows) {
  auto map = std::make_shared<Map>();
  const bool read = with_head(
      rows, [&](std::string_view body, std::int64_t, const std::string& where) { read_head(body, where, *map); });
  if (!read) throw Error("nothing of a map was found", rows.file(), "give the map.rastro of a run");
  read_cameras(rows, map->cameras);
  read_list(rows, "sessions", map->sessions, read_session);
  rows.each("keyframes", [&](std::string_view body, std::int64_t id, const std::string& where) {
    map->keyframes.push_back(read_keyframe(body, id, where));
  });
  read_list(rows, "constraints", map->constraints, read_constraint);
  read_list(rows, "frames", map->frames, read_frame);
  for (const NamedHeader& named : layers_in(rows)) map->layers.put(named.name, layer_in(rows, named));
  return map;
}

/// A keyframe whose parents do not lead to a root becomes one.
void repair_tree(Map& map) {
  for (Keyframe& keyframe : map.keyframes)
    if (keyframe.parent != no_keyframe && !map.index_of(keyframe.parent)) keyframe.parent = no_keyframe;
  for (Keyframe& keyframe : map.keyframes) {
    std::size_t steps = 0;
    for (const Keyframe* at = &keyframe; at->parent != no_keyframe; at = map.find(at->parent))
      if (++steps > map.keyframes.size()) {
        keyframe.parent = no_keyframe;
        break;
      }
  }
}

}  // namespace

bool with_head(RowSource& rows, const RowSource::Read& read) {
  bool done = false;
  const auto once = [&](std::int64_t wanted) {
    return [&, wanted](std::string_view body, std::int64_t id, const std::string& where) {
      if (id != wanted || done) return;
      read(body, id, where);
      done = true;
    };
  };
  rows.each("head", once(0));
  if (!done) rows.each("contents", once(second_head_row));
  return done;
}

std::shared_ptr<Map> read_map(RowSource& rows, std::uint32_t version) {
  if (version == 1) return read_depth_camera_map(rows);
  if (version == 2) return read_landmark_map(rows);
  return read_layered_map(rows);
}

void repair(Map& map) {
  std::erase_if(map.keyframes, [&](const Keyframe& keyframe) {
    return static_cast<std::size_t>(keyframe.camera) >= std::max<std::size_t>(1, map.cameras.size());
  });
  repair_tree(map);
  std::erase_if(map.constraints, [&](const Constraint& each) {
    return !map.index_of(each.from) || !map.index_of(each.to) || !fault_of(each).empty();
  });
  std::erase_if(map.frames, [&](const MapFrame& frame) { return !map.index_of(frame.keyframe); });
  // Features must be read before the layers that refer to them; the order of layer names does not ensure this.
  for (int round = 0; round < 2; ++round) {
    const LayerSet::Layers layers = map.layers.all();
    for (const auto& [name, layer] : layers)
      if (const LayerType* type = layer_type(name)) map.layers.put(name, type->repaired(map, layer));
  }
}

}  // namespace rastro
