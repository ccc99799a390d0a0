// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/graph_paths.h"

#include <limits>
#include <utility>

namespace rastro {

GraphPaths::GraphPaths(std::int64_t from, LinksOf links_of) : links_of_(std::move(links_of)) {
  shortest_[from] = 0.0;
  next_.emplace(0.0, from);
}

double GraphPaths::to(std::int64_t node) {
  const auto length_of = [this](std::int64_t id) {
    const auto found = shortest_.find(id);
    return found == shortest_.end() ? std::numeric_limits<double>::infinity() : found->second;
  };
  // What is not longer than everything still to be followed is final.
  while (!next_.empty() && next_.top().first < length_of(node)) {
    const auto [length, id] = next_.top();
    next_.pop();
    if (length > length_of(id)) continue;
    for (const Link& link : links_of_(id)) {
      if (length + link.length >= length_of(link.other)) continue;
      shortest_[link.other] = length + link.length;
      next_.emplace(length + link.length, link.other);
    }
  }
  return length_of(node);
}

}  // namespace rastro
