// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/keyframe_database.h"

#include <algorithm>

namespace rastro {
namespace {

/// Features of use under each node, nodes ascending.
using ByNode = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

ByNode by_node(const FeatureFrame& frame, const BagOfWords& words, const std::vector<std::uint8_t>& use) {
  ByNode result;
  for (std::uint32_t i = 0; i < frame.size() && i < words.nodes.size(); ++i) {
    if (use.empty() || use[i] != 0) result.emplace_back(words.nodes[i], i);
  }
  std::sort(result.begin(), result.end());
  return result;
}

struct Nearest {
  std::int64_t feature = -1;
  int distance = 257, second = 257;
};

/// For each feature of `from` the nearest of `to` under the same node.
std::vector<Nearest> nearest_of(const FeatureFrame& from, const ByNode& from_nodes, const FeatureFrame& to,
                                const ByNode& to_nodes) {
  std::vector<Nearest> result(from.size());
  auto begin = to_nodes.begin();
  for (const auto& [node, feature] : from_nodes) {
    while (begin != to_nodes.end() && begin->first < node) ++begin;
    Nearest& nearest = result[feature];
    for (auto at = begin; at != to_nodes.end() && at->first == node; ++at) {
      const int distance = hamming_distance(from.descriptor(feature), to.descriptor(at->second));
      if (distance < nearest.distance) {
        nearest.second = nearest.distance;
        nearest.distance = distance;
        nearest.feature = at->second;
      } else if (distance < nearest.second) {
        nearest.second = distance;
      }
    }
  }
  return result;
}

}  // namespace

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

std::vector<std::pair<std::uint32_t, std::uint32_t>> match_by_words(
    const FeatureFrame& first, const BagOfWords& first_words, const std::vector<std::uint8_t>& use_first,
    const FeatureFrame& second, const BagOfWords& second_words, const std::vector<std::uint8_t>& use_second,
    const MatchLimits& limits) {
  const ByNode first_nodes = by_node(first, first_words, use_first);
  const ByNode second_nodes = by_node(second, second_words, use_second);
  const std::vector<Nearest> there = nearest_of(first, first_nodes, second, second_nodes);
  const std::vector<Nearest> back = nearest_of(second, second_nodes, first, first_nodes);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (std::uint32_t i = 0; i < there.size(); ++i) {
    const Nearest& nearest = there[i];
    if (nearest.feature < 0 || nearest.distance > limits.max_distance ||
        nearest.distance > limits.max_ratio * nearest.second)
      continue;
    if (back[static_cast<std::size_t>(nearest.feature)].feature == i)
      pairs.emplace_back(i, static_cast<std::uint32_t>(nearest.feature));
  }
  return pairs;
}

}  // namespace rastro
