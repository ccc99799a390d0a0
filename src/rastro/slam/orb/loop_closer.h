// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "rastro/multiview/similarity.h"
#include "rastro/slam/orb/local_mapper.h"
#include "rastro/slam/orb/options.h"
#include "rastro/slam/orb/place_memory.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// A place that was recognised, and what the map made of it.
struct LoopResult {
  std::int64_t keyframe = 0, matched = 0;
  bool joined = false;  ///< Two submaps became one; else a loop within one was closed.
  int inliers = 0;      ///< Pairs of landmarks that fit the similarity.
  int landmarks = 0;    ///< Of the place, found again in the keyframe.
  int fused = 0;        ///< Landmarks that turned out to be the same.
  double moved = 0.0;   ///< By how much the keyframe's centre moved, the map's unit.
  double scale = 1.0;   ///< By which its surroundings were rescaled.
  SlamEvent event() const;
};

/// Recognises places and makes the map agree with itself, METHODS 6 (Mur-Artal et al. 2015, section VII): loops within
/// a submap, and submaps that turn out to be one.
class LoopCloser {
 public:
  /// All outlive this.
  LoopCloser(const OrbSlamOptions& options, MapGraph& graph, LocalMapper& mapper, PlaceMemory& places);

  /// After local mapping of a keyframe; call it for each, in order. What it returns has been done to the graph.
  std::optional<LoopResult> consider(std::int64_t keyframe);

 private:
  /// A group of keyframes that looks alike, and for how many keyframes in a row it has.
  struct Group {
    std::vector<std::int64_t> keyframes;  ///< Ascending.
    int times = 1;
  };
  struct Match {
    Sim3 keyframe_from_matched;
    int inliers = 0;
    /// Features of the keyframe and landmarks of the place.
    std::vector<std::pair<std::uint32_t, std::int64_t>> found;
  };

  double least_score(const MapKeyframe& keyframe) const;
  std::vector<std::int64_t> candidates(const MapKeyframe& keyframe) const;
  std::vector<std::int64_t> consistent(const std::vector<std::int64_t>& candidates);
  std::optional<Match> verify(std::int64_t keyframe, std::int64_t candidate) const;
  std::vector<SimilarityPair> pairs_of(const MapKeyframe& first, const MapKeyframe& second,
                                       const std::vector<std::pair<std::uint32_t, std::uint32_t>>& features) const;

  OrbSlamOptions options_;
  MapGraph& graph_;
  LocalMapper& mapper_;
  PlaceMemory& places_;
  std::vector<Group> groups_;
  std::int64_t last_closed_ = -1;
};

}  // namespace rastro
