// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/backend/word_matching.h"
#include "rastro/place/place_index.h"
#include "rastro/place/vocabulary.h"
#include "rastro/slam/orb/map/map_graph.h"

namespace rastro {

/// Bag-of-words database of the map's keyframes. Not thread-safe, like the graph.
class KeyframeDatabase {
 public:
  /// The graph outlives this.
  KeyframeDatabase(MapGraph& graph, std::shared_ptr<const Vocabulary> vocabulary);

  /// Adds new keyframes and removes those that are gone; sets MapKeyframe::words.
  void update();
  BagOfWords words_of(const FeatureFrame& frame) const;
  const PlaceIndex& index() const { return index_; }

 private:
  MapGraph& graph_;
  std::shared_ptr<const Vocabulary> vocabulary_;
  PlaceIndex index_;
  std::vector<std::int64_t> known_;  ///< Ascending.
};

/// For match_by_words(). Features whose `use` (empty, or one per feature) is zero are skipped. The caller owns all
/// arguments.
WordedFeatures worded_features(const FeatureFrame& frame, const BagOfWords& words,
                               const std::vector<std::uint8_t>& use);

}  // namespace rastro
