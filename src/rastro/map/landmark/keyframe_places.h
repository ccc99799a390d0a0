// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "rastro/map/landmark/landmark_map.h"

namespace rastro {

/// Finds the place of a keyframe in LandmarkMap::keyframes, and so in its poses, by its id.
class KeyframePlaces {
 public:
  explicit KeyframePlaces(const LandmarkMap& map) {
    ids_.reserve(map.keyframes.size());
    for (const auto& keyframe : map.keyframes) ids_.push_back(keyframe->id);
  }

  std::optional<std::size_t> of(std::int64_t id) const {
    const auto found = std::lower_bound(ids_.begin(), ids_.end(), id);
    if (found == ids_.end() || *found != id) return std::nullopt;
    return static_cast<std::size_t>(found - ids_.begin());
  }

 private:
  std::vector<std::int64_t> ids_;  ///< Ascending.
};

}  // namespace rastro
