// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/graph/edit.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/map/layer_type.h"

namespace rastro {
namespace {

std::string named(KeyframeId id) { return fmt::format("keyframe {}", id); }

std::vector<Keyframe>::iterator insertion_point(Map& map, KeyframeId id) {
  return std::lower_bound(map.keyframes.begin(), map.keyframes.end(), id,
                          [](const Keyframe& keyframe, KeyframeId wanted) { return keyframe.id < wanted; });
}

/// Moves the elements for which `holds` is true to another list, with their indices.
template <typename Item, typename Holds>
void take_if(std::vector<Item>& from, std::vector<std::pair<std::size_t, Item>>& to, Holds holds) {
  for (std::size_t i = 0; i < from.size(); ++i)
    if (holds(from[i])) to.emplace_back(i, from[i]);
  std::erase_if(from, holds);
}

/// Inserts those for which `holds` is still true at their indices, as far as the list reaches.
template <typename Item, typename Holds>
void put_back(const std::vector<std::pair<std::size_t, Item>>& from, std::vector<Item>& to, Holds holds) {
  for (const auto& [index, item] : from)
    if (holds(item)) to.insert(to.begin() + static_cast<std::ptrdiff_t>(std::min(index, to.size())), item);
}

void cut_layers(Map& map, RemovedKeyframe& removed) {
  const LayerSet::Layers layers = map.layers.all();
  for (const auto& [name, layer] : layers) {
    if (const LayerType* type = layer_type(name)) {
      LayerCut cut = type->cut(*layer, removed.keyframe.id);
      map.layers.put(name, std::move(cut.rest));
      removed.layers[name] = std::move(cut.bytes);
    } else {
      removed.unknown_layers.put(name, layer);
      map.layers.put(name, nullptr);
    }
  }
  if (removed.unknown_layers.all().empty()) return;
  for (const Keyframe& keyframe : map.keyframes) removed.others.push_back(keyframe.id);
}

void paste_layers(Map& map, const RemovedKeyframe& removed) {
  for (const auto& [name, bytes] : removed.layers) {
    const LayerType* type = layer_type(name);
    const auto layer = map.layers.find(name);
    if (type && layer) map.layers.put(name, type->paste(*layer, removed.keyframe.id, bytes));
  }
  if (!std::all_of(removed.others.begin(), removed.others.end(), [&](KeyframeId id) { return map.index_of(id); }))
    return;
  for (const auto& [name, layer] : removed.unknown_layers.all())
    if (!map.layers.find(name)) map.layers.put(name, layer);
}

}  // namespace

void insert_keyframe(Map& map, const Keyframe& keyframe) {
  const auto at = insertion_point(map, keyframe.id);
  if (keyframe.id < 0) throw Error("has an id below 0", named(keyframe.id), "make ids with keyframe_id()");
  if (at != map.keyframes.end() && at->id == keyframe.id)
    throw Error("the map has a keyframe of this id", named(keyframe.id), "give it one of its own");
  if (keyframe.camera < 0 || static_cast<std::size_t>(keyframe.camera) >= std::max<std::size_t>(1, map.cameras.size()))
    throw Error("is of a camera that the map does not have", named(keyframe.id), "add the camera first");
  if (keyframe.parent != no_keyframe && !map.index_of(keyframe.parent))
    throw Error("has a parent that the map does not have", named(keyframe.id), "insert the parent first");
  map.keyframes.insert(at, keyframe);
  ++map.revision;
}

RemovedKeyframe remove_keyframe(Map& map, KeyframeId id) {
  const auto at = insertion_point(map, id);
  if (at == map.keyframes.end() || at->id != id)
    throw Error("the map has no such keyframe", named(id), "'rastro info' counts them");
  RemovedKeyframe removed;
  removed.keyframe = *at;
  map.keyframes.erase(at);
  for (Keyframe& keyframe : map.keyframes) {
    if (keyframe.parent != id) continue;
    removed.children.push_back(keyframe.id);
    keyframe.parent = removed.keyframe.parent;
  }
  take_if(map.constraints, removed.constraints,
          [id](const Constraint& each) { return each.from == id || each.to == id; });
  take_if(map.frames, removed.frames, [id](const MapFrame& frame) { return frame.keyframe == id; });
  cut_layers(map, removed);
  ++map.revision;
  return removed;
}

void restore_keyframe(Map& map, const RemovedKeyframe& removed) {
  Keyframe keyframe = removed.keyframe;
  if (!map.index_of(keyframe.parent)) keyframe.parent = no_keyframe;
  insert_keyframe(map, keyframe);
  for (const KeyframeId id : removed.children) {
    const auto index = map.index_of(id);
    if (index && map.keyframes[*index].parent == keyframe.parent) map.keyframes[*index].parent = keyframe.id;
  }
  put_back(removed.constraints, map.constraints,
           [&](const Constraint& each) { return map.index_of(each.from) && map.index_of(each.to); });
  put_back(removed.frames, map.frames, [](const MapFrame&) { return true; });
  paste_layers(map, removed);
}

Map renumbered(const Map& map) {
  const auto number = static_cast<std::int64_t>(map.keyframes.size());
  if (map.keyframes.empty() || (map.keyframes.front().id == 0 && map.keyframes.back().id == number - 1)) return map;
  std::map<KeyframeId, KeyframeId> new_id{{no_keyframe, no_keyframe}};
  for (const Keyframe& keyframe : map.keyframes)
    new_id.emplace(keyframe.id, static_cast<KeyframeId>(new_id.size()) - 1);
  Map result = map;
  for (Keyframe& keyframe : result.keyframes) {
    keyframe.id = new_id.at(keyframe.id);
    keyframe.parent = new_id.at(keyframe.parent);
  }
  for (Constraint& each : result.constraints) each.from = new_id.at(each.from), each.to = new_id.at(each.to);
  for (MapFrame& frame : result.frames) frame.keyframe = new_id.at(frame.keyframe);
  for (const auto& [name, layer] : map.layers.all()) {
    const LayerType* type = layer_type(name);
    result.layers.put(name, type ? type->renumbered(layer, new_id) : nullptr);
  }
  return result;
}

}  // namespace rastro
