// SPDX-License-Identifier: Apache-2.0
#include "rastro/place/vocabulary.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/feature/hamming.h"

namespace rastro {

double similarity(const BagOfWords& a, const BagOfWords& b) {
  // 1 - |a - b|_1 / 2 is the sum of the smaller weights.
  double common = 0.0;
  auto p = a.words.begin(), q = b.words.begin();
  while (p != a.words.end() && q != b.words.end()) {
    if (p->first == q->first) {
      common += static_cast<double>(std::min(p->second, q->second));
      ++p;
      ++q;
    } else if (p->first < q->first) {
      ++p;
    } else {
      ++q;
    }
  }
  return std::min(common, 1.0);
}

void Vocabulary::number_words() {
  words_ = 0;
  for (Node& node : nodes_)
    if (node.children == 0) node.word = static_cast<std::uint32_t>(words_++);
}

BagOfWords Vocabulary::words_of(std::span<const Descriptor> descriptors, int node_depth) const {
  RASTRO_CHECK(node_depth >= 1, "a depth of the tree");
  BagOfWords bag;
  bag.nodes.reserve(descriptors.size());
  std::vector<std::pair<std::uint32_t, float>> found;
  found.reserve(descriptors.size());
  std::array<std::uint16_t, 256> distances;
  for (const Descriptor& descriptor : descriptors) {
    std::uint32_t at = 0, marked = 0;
    while (nodes_[at].children > 0) {
      const Node& node = nodes_[at];
      hamming_distances(descriptor, {&centers_[node.first_child], node.children}, distances);
      const auto nearest = std::min_element(distances.begin(), distances.begin() + node.children);
      at = node.first_child + static_cast<std::uint32_t>(nearest - distances.begin());
      if (nodes_[at].depth <= node_depth) marked = at;
    }
    bag.nodes.push_back(marked);
    found.emplace_back(nodes_[at].word, nodes_[at].weight);
  }
  std::sort(found.begin(), found.end());
  double sum = 0.0;
  for (const auto& [word, weight] : found) {
    if (weight <= 0.0F) continue;
    if (bag.words.empty() || bag.words.back().first != word) bag.words.emplace_back(word, 0.0F);
    bag.words.back().second += weight;
    sum += static_cast<double>(weight);
  }
  for (auto& [word, share] : bag.words) share = static_cast<float>(static_cast<double>(share) / sum);
  return bag;
}

}  // namespace rastro
