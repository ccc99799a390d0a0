// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/landmark/landmark_checks.h"

#include <algorithm>
#include <cmath>

#include "rastro/map/landmark/keyframe_places.h"

namespace rastro {
namespace {

std::string in_keyframe(const LandmarkKeyframe& keyframe, int levels) {
  const OrbFeatures& features = keyframe.features;
  const std::size_t count = features.size();
  if (features.levels.size() != count || features.descriptors.size() != count)
    return "has a keyframe whose features are not all described";
  if ((!keyframe.right_x.empty() && keyframe.right_x.size() != count) ||
      (!keyframe.depths.empty() && keyframe.depths.size() != count))
    return "has a keyframe with depths for some of its features only";
  if (std::any_of(features.levels.begin(), features.levels.end(), [&](int level) { return level >= levels; }))
    return "has a feature of a level that there is not";
  return "";
}

std::string in_keyframes(const LandmarkMap& map) {
  if (map.poses.size() != map.keyframes.size()) return "does not have a pose for every keyframe";
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    if (!map.keyframes[k]) return "lacks a keyframe";
    if (map.keyframes[k]->id < 0 || (k > 0 && map.keyframes[k]->id <= map.keyframes[k - 1]->id))
      return "has keyframes out of order";
    if (std::string fault = in_keyframe(*map.keyframes[k], map.features.levels); !fault.empty()) return fault;
  }
  return "";
}

/// A keyframe whose way up the tree does not end at a root stands in a ring.
std::string in_tree(const LandmarkMap& map, const KeyframePlaces& places) {
  enum : std::uint8_t { unknown, on_the_way, ends };
  std::vector<std::uint8_t> state(map.poses.size(), unknown);
  for (std::size_t start = 0; start < map.poses.size(); ++start) {
    std::vector<std::size_t> way;
    std::size_t at = start;
    while (state[at] == unknown) {
      state[at] = on_the_way;
      way.push_back(at);
      if (map.poses[at].parent < 0) break;
      const auto parent = places.of(map.poses[at].parent);
      if (!parent) return "has a spanning tree that leads to a keyframe that is not there";
      at = *parent;
      if (state[at] == on_the_way) return "has a spanning tree with a ring in it";
    }
    for (const std::size_t k : way) state[k] = ends;
  }
  return "";
}

std::string in_landmarks(const LandmarkMap& map, const KeyframePlaces& places) {
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    const Landmark& landmark = map.landmarks[i];
    if (landmark.id < 0 || (i > 0 && landmark.id <= map.landmarks[i - 1].id)) return "has landmarks out of order";
    if (!landmark.position.allFinite() || !landmark.direction.allFinite()) return "has a landmark without a place";
    std::int64_t last = -1;
    for (const LandmarkObservation& observation : landmark.observations) {
      const auto keyframe = places.of(observation.keyframe);
      if (!keyframe || observation.keyframe <= last) return "has a landmark seen by a keyframe that is not there";
      last = observation.keyframe;
      if (observation.feature >= map.keyframes[*keyframe]->features.size())
        return "has a landmark seen by a feature that is not there";
    }
  }
  return "";
}

}  // namespace

std::string contradiction_in(const LandmarkMap& map) {
  if (std::string fault = in_keyframes(map); !fault.empty()) return fault;
  const KeyframePlaces places(map);
  if (std::string fault = in_tree(map, places); !fault.empty()) return fault;
  if (std::string fault = in_landmarks(map, places); !fault.empty()) return fault;
  for (const LandmarkTie& tie : map.ties)
    if (!places.of(tie.from) || !places.of(tie.to)) return "has a tie to a keyframe that is not there";
  return "";
}

}  // namespace rastro
