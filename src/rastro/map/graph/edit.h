// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "rastro/map/graph/map.h"

namespace rastro {

/// A keyframe removed from a map, with everything attached to it: enough to restore it.
struct RemovedKeyframe {
  Keyframe keyframe;
  /// To keyframes of the map, and frames relative to it; each with its index in the map's list.
  std::vector<std::pair<std::size_t, Constraint>> constraints;
  std::vector<std::pair<std::size_t, MapFrame>> frames;
  std::vector<KeyframeId> children;  ///< Keyframes whose parent it was.
  std::map<std::string, std::string> layers;
  /// Layers of other programs, whole: nothing tells which of their rows refer to the keyframe, or contain its id.
  LayerSet unknown_layers;
  std::vector<KeyframeId> others;  ///< Where there are such layers: all other keyframes, which they may refer to, too.
};

// Each of these three gives the map a new revision.

/// Inserts a keyframe in the order of ids. Error where the map has one with that id, or lacks its camera or parent.
void insert_keyframe(Map& map, const Keyframe& keyframe);
/// Its children in the spanning tree become children of its parent. Frames relative to it are removed with it. Error if
/// the map does not have it.
RemovedKeyframe remove_keyframe(Map& map, KeyframeId id);
/// Restores it as it was, without references to keyframes that have been removed since; then without layers of other
/// programs, too.
void restore_keyframe(Map& map, const RemovedKeyframe& removed);

/// The same map with keyframe numbers 0, 1, ... in the order of their ids, for methods that index by them; the map
/// itself if they already are. Layers that this program does not know are left out, since they may contain ids.
Map renumbered(const Map& map);

}  // namespace rastro
