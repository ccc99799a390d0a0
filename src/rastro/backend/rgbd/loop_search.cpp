// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/loop_search.h"

#include "rastro/slam/map_budget.h"

namespace rastro {

LoopSearch::Candidates GraphSearch::candidates(const KeyframeGraph& graph, std::int64_t id) {
  Random random(seed_for(options_.follow.seed, static_cast<std::uint64_t>(id)));
  return {graph.candidates(id, random), {}, {}};
}

std::vector<std::int64_t> GraphSearch::transfer(const KeyframeGraph& graph, double fill) {
  constexpr int others = 3;
  if (fill > MapBudget::full_share) {
    if (const auto id = graph.most_redundant(others)) return {*id};
  }
  if (fill <= 1.0) return {};
  for (std::int64_t id = graph.frozen(); id < graph.size() - options_.graph_window; ++id)
    if (graph.keyframe(id).features.size() > 0) return {id};
  return {};
}

}  // namespace rastro
