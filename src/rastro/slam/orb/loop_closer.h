// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rastro/slam/orb/loop_correction.h"
#include "rastro/slam/orb/options.h"
#include "rastro/slam/orb/place_memory.h"

namespace rastro {

/// Recognises places and makes the map agree with itself, METHODS 6 (Mur-Artal et al. 2015, section VII): loops within
/// a submap, and submaps that turn out to be one.
class LoopCloser {
 public:
  /// All outlive this.
  LoopCloser(const OrbSlamOptions& options, MapGraph& graph, PlaceMemory& places);

  /// After local mapping of a keyframe; call it for each, in order. What it returns has been done to the graph.
  std::optional<LoopResult> consider(std::int64_t keyframe);

 private:
  /// A group of keyframes that looks alike, and for how many keyframes in a row it has.
  struct Group {
    std::vector<std::int64_t> keyframes;  ///< Ascending.
    int times = 1;
  };

  double least_score(const MapKeyframe& keyframe) const;
  std::vector<std::int64_t> candidates(const MapKeyframe& keyframe) const;
  std::vector<std::int64_t> consistent(const std::vector<std::int64_t>& candidates);
  std::optional<PlaceFound> verify(std::int64_t keyframe, std::int64_t candidate) const;

  OrbSlamOptions options_;
  MapGraph& graph_;
  PlaceMemory& places_;
  std::vector<Group> groups_;
  std::int64_t last_closed_ = -1;
};

}  // namespace rastro
