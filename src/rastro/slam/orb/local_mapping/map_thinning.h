// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "rastro/slam/map_budget.h"
#include "rastro/slam/orb/map/map_graph.h"
#include "rastro/slam/orb/options.h"

namespace rastro {

/// How many of a keyframe's landmarks (without the far ones) at least three other keyframes observe at most one level
/// coarser.
struct Redundancy {
  int landmarks = 0, redundant = 0;
  double share() const { return landmarks == 0 ? 1.0 : static_cast<double>(redundant) / landmarks; }
};
Redundancy redundancy_of(const MapGraph& graph, const MapKeyframe& keyframe, const OrbSlamOptions& options);

/// Keeps the map within its memory budget: from 90 % on it removes the most redundant keyframes of the whole map,
/// beyond 100 % also less redundant ones. Never removes the root of a submap, a keyframe of a loop, or the newest.
/// Accesses the graph as local mapping does.
class MapThinning {
 public:
  /// Both outlive this.
  MapThinning(const OrbSlamOptions& options, MapGraph& graph, std::size_t budget_bytes)
      : options_(options), graph_(graph), budget_(budget_bytes) {}

  bool limited() const { return budget_.limited(); }
  const MapBudget& budget() const { return budget_; }
  /// After local mapping of a keyframe. `trajectory_bytes`: memory of the frames outside the graph.
  void process(std::size_t trajectory_bytes, std::vector<SlamEvent>& events);
  MapMemory memory(std::size_t trajectory_bytes) const;

 private:
  std::size_t graph_bytes() const;
  std::string measures() const;
  std::vector<std::int64_t> removable() const;
  bool remove_redundant(std::size_t trajectory_bytes);

  const OrbSlamOptions& options_;
  MapGraph& graph_;
  MapBudget budget_;
  int removed_ = 0;
};

}  // namespace rastro
