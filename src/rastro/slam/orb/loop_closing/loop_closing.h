// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rastro/multiview/similarity.h"
#include "rastro/slam/orb/loop_closing/loop_correction.h"
#include "rastro/slam/orb/map/keyframe_database.h"
#include "rastro/slam/orb/options.h"

namespace rastro {

/// Closes loops within a submap and merges submaps that turn out to be one, METHODS 6 (Mur-Artal et al. 2015, section
/// VII).
class LoopClosing {
 public:
  /// All outlive this.
  LoopClosing(const OrbSlamOptions& options, MapGraph& graph, KeyframeDatabase& database);

  /// After local mapping of a keyframe; call it for each, in order. What it returns has been done to the graph.
  std::optional<LoopResult> process(std::int64_t keyframe);

 private:
  /// A group of keyframes that look alike, and for how many keyframes in a row it has.
  struct Group {
    std::vector<std::int64_t> keyframes;  ///< Ascending.
    int times = 1;
  };

  std::vector<std::int64_t> detect_candidates(const MapKeyframe& keyframe) const;
  double min_score(const MapKeyframe& keyframe) const;
  std::vector<PlaceMatch> similar_keyframes(const MapKeyframe& keyframe) const;
  std::vector<std::int64_t> consistent(const std::vector<std::int64_t>& candidates);
  std::optional<VerifiedLoop> verify(const MapKeyframe& keyframe, const MapKeyframe& candidate) const;
  std::optional<SimilarityFit> find_similarity(const MapKeyframe& keyframe, const MapKeyframe& candidate) const;
  MatchLimits limits() const { return {options_.place_hamming, options_.place_ratio}; }

  OrbSlamOptions options_;
  MapGraph& graph_;
  KeyframeDatabase& database_;
  std::vector<Group> groups_;
  std::int64_t last_closed_ = -1;
};

}  // namespace rastro
