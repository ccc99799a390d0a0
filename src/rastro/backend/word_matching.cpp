// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/word_matching.h"

#include <algorithm>

#include "rastro/feature/brief.h"

namespace rastro {
namespace {

/// Used features by node, nodes ascending.
using ByNode = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

ByNode by_node(const WordedFeatures& image) {
  ByNode result;
  for (std::uint32_t i = 0; i < image.descriptors.size() && i < image.words.nodes.size(); ++i) {
    if (image.use.empty() || image.use[i] != 0) result.emplace_back(image.words.nodes[i], i);
  }
  std::sort(result.begin(), result.end());
  return result;
}

struct NearestInNode {
  std::int64_t feature = -1;
  int distance = 257, second = 257;
};

/// For each feature of `from` the most similar one of `to` under the same node.
std::vector<NearestInNode> nearest_of(const WordedFeatures& from, const ByNode& from_nodes, const WordedFeatures& to,
                                      const ByNode& to_nodes) {
  std::vector<NearestInNode> result(from.descriptors.size());
  auto begin = to_nodes.begin();
  for (const auto& [node, feature] : from_nodes) {
    while (begin != to_nodes.end() && begin->first < node) ++begin;
    NearestInNode& nearest = result[feature];
    for (auto at = begin; at != to_nodes.end() && at->first == node; ++at) {
      const int distance = hamming_distance(from.descriptors[feature], to.descriptors[at->second]);
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

std::vector<std::pair<std::uint32_t, std::uint32_t>> match_by_words(const WordedFeatures& first,
                                                                    const WordedFeatures& second,
                                                                    const MatchLimits& limits) {
  const ByNode first_nodes = by_node(first), second_nodes = by_node(second);
  const std::vector<NearestInNode> there = nearest_of(first, first_nodes, second, second_nodes);
  const std::vector<NearestInNode> back = nearest_of(second, second_nodes, first, first_nodes);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (std::uint32_t i = 0; i < there.size(); ++i) {
    const NearestInNode& nearest = there[i];
    if (nearest.feature < 0 || nearest.distance > limits.max_distance ||
        nearest.distance > limits.max_ratio * nearest.second)
      continue;
    if (back[static_cast<std::size_t>(nearest.feature)].feature == i)
      pairs.emplace_back(i, static_cast<std::uint32_t>(nearest.feature));
  }
  return pairs;
}

}  // namespace rastro
