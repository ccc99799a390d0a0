// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/keyframe_database.h"

#include <utility>

namespace rastro {
KeyframeDatabase::KeyframeDatabase(MapGraph& graph, std::shared_ptr<const Vocabulary> vocabulary)
    : graph_(graph), vocabulary_(std::move(vocabulary)) {}

BagOfWords KeyframeDatabase::words_of(const FeatureFrame& frame) const {
  return vocabulary_->words_of(frame.data().features.descriptors);
}

void KeyframeDatabase::update() {
  std::vector<std::int64_t> now = graph_.keyframe_ids();
  for (const std::int64_t id : known_) {
    if (!graph_.has_keyframe(id)) index_.remove(id);
  }
  for (const std::int64_t id : now) {
    if (index_.contains(id)) continue;
    MapKeyframe& keyframe = graph_.keyframe(id);
    keyframe.words = std::make_shared<const BagOfWords>(words_of(*keyframe.frame));
    index_.add(id, *keyframe.words);
  }
  known_ = std::move(now);
}

WordedFeatures worded_features(const FeatureFrame& frame, const BagOfWords& words,
                               const std::vector<std::uint8_t>& use) {
  return {frame.data().features.descriptors, words, use};
}

}  // namespace rastro
