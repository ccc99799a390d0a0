// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rastro/backend/acceptance.h"
#include "rastro/multiview/similarity.h"
#include "rastro/slam/orb/loop_closing/loop_correction.h"
#include "rastro/slam/orb/map/keyframe_database.h"
#include "rastro/slam/orb/options.h"

namespace rastro {

/// Closes loops within a submap and merges submaps that show the same place, METHODS 6 (Mur-Artal et al. 2015, section
/// VII).
class LoopClosing {
 public:
  /// All outlive this.
  LoopClosing(const OrbSlamOptions& options, MapGraph& graph, KeyframeDatabase& database);

  /// Call after local mapping of each keyframe, in order. The returned correction has been applied to the graph.
  std::optional<LoopResult> process(std::int64_t keyframe);

 private:
  std::vector<Hypothesis> detect_candidates(const MapKeyframe& keyframe) const;
  std::optional<VerifiedLoop> verify(const MapKeyframe& keyframe, const MapKeyframe& candidate) const;
  std::optional<SimilarityFit> find_similarity(const MapKeyframe& keyframe, const MapKeyframe& candidate) const;
  MatchLimits limits() const { return {options_.place_hamming, options_.place_ratio}; }

  OrbSlamOptions options_;
  MapGraph& graph_;
  KeyframeDatabase& database_;
  Acceptance acceptance_;
  std::int64_t last_closed_ = -1;
};

}  // namespace rastro
