// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <optional>

#include "rastro/map/landmark/keyframe_places.h"

namespace rastro {

/// Which keyframes and landmarks belong to the part of a map that is asked for.
class LandmarkPart {
 public:
  LandmarkPart(const LandmarkMap& map, int submap) : map_(map), places_(map), submap_(submap) {}

  bool has_keyframe(std::size_t place) const { return submap_ < 0 || map_.poses[place].submap == submap_; }
  /// The place of the first keyframe of the part that sees the landmark.
  std::optional<std::size_t> first_viewer(const Landmark& landmark) const {
    for (const LandmarkObservation& observation : landmark.observations)
      if (const auto place = places_.of(observation.keyframe); place && has_keyframe(*place)) return place;
    return std::nullopt;
  }
  const KeyframePlaces& places() const { return places_; }

 private:
  const LandmarkMap& map_;
  KeyframePlaces places_;
  int submap_;
};

}  // namespace rastro
