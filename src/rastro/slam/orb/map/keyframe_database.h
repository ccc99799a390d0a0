// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "rastro/backend/guided_search.h"
#include "rastro/place/place_index.h"
#include "rastro/place/vocabulary.h"
#include "rastro/slam/orb/map/map_graph.h"

namespace rastro {

/// What the keyframes of a map look like, to find them again. One thread at a time, like the graph.
class KeyframeDatabase {
 public:
  /// The graph outlives this.
  KeyframeDatabase(MapGraph& graph, std::shared_ptr<const Vocabulary> vocabulary);

  /// Learns the keyframes that are new and forgets those that are gone; sets MapKeyframe::words.
  void update();
  BagOfWords words_of(const FeatureFrame& frame) const;
  const PlaceIndex& index() const { return index_; }

 private:
  MapGraph& graph_;
  std::shared_ptr<const Vocabulary> vocabulary_;
  PlaceIndex index_;
  std::vector<std::int64_t> known_;  ///< Ascending.
};

/// Features of two pictures that fall under the same node of the vocabulary and are each other's most similar; pairs
/// ascend. Features whose `use` (empty or one a feature) is zero are passed over.
std::vector<std::pair<std::uint32_t, std::uint32_t>> match_by_words(
    const FeatureFrame& first, const BagOfWords& first_words, const std::vector<std::uint8_t>& use_first,
    const FeatureFrame& second, const BagOfWords& second_words, const std::vector<std::uint8_t>& use_second,
    const MatchLimits& limits);

}  // namespace rastro
