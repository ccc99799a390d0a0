// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "rastro/map/graph/map.h"

namespace rastro {

/// A keyframe taken out of a map, with all that goes with it: enough to bring it back.
struct RemovedKeyframe {
  Keyframe keyframe;
  /// To keyframes of the map, and frames relative to it; each with its place in the map's list.
  std::vector<std::pair<std::size_t, Constraint>> constraints;
  std::vector<std::pair<std::size_t, MapFrame>> frames;
  std::vector<KeyframeId> children;  ///< Whose parent it was.
  std::map<std::string, std::string> layers;
};

// These three give the map a new revision.

/// Puts a keyframe in its place; Error where the map has one of that id, or lacks its camera or parent.
void insert_keyframe(Map& map, const Keyframe& keyframe);
/// Its children in the spanning tree go to its parent. Frames placed relative to it go with it. Error where it is not
/// there.
RemovedKeyframe remove_keyframe(Map& map, KeyframeId id);
/// Brings it back as it was; what refers to keyframes that are gone meanwhile is left out.
void restore_keyframe(Map& map, const RemovedKeyframe& removed);

/// The same map with keyframe numbers 0, 1, ... in the order of their ids, for methods that count them; the map itself
/// where they are so already.
Map renumbered(const Map& map);

}  // namespace rastro
