// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/optimize/bundle_adjustment.h"
#include "rastro/slam/orb/map/map_graph.h"

namespace rastro {

/// A part of the map as a bundle adjustment problem: a copy, so the map may change meanwhile.
struct BundleProblem {
  using Seen = std::pair<std::int64_t, std::int64_t>;  ///< A keyframe and a landmark it observes.

  Bundle bundle;
  std::vector<std::int64_t> keyframes, landmarks;  ///< Ids of each camera and point of the bundle.
  std::vector<Seen> seen;                          ///< One per observation.
  std::vector<Seen> outliers;                      ///< Removed by adjust_bundle_problem().
};

/// The landmarks observed by the keyframes of `free`, and their observations from both lists; keyframes of `fixed` stay
/// fixed. `pixel_sigma`: standard deviation of a feature's position at the finest level, pixels.
BundleProblem bundle_problem(const MapGraph& graph, const std::vector<std::int64_t>& free,
                             const std::vector<std::int64_t>& fixed, double pixel_sigma);

/// Two rounds: at most half of `iterations`, then all of them. After each, observations beyond 95 % of chi-square are
/// removed. Stops early once `stopped` (may be empty) returns true.
void adjust_bundle_problem(BundleProblem& problem, int iterations, const std::function<bool()>& stopped,
                           TaskPool* pool);

/// Removes the outliers of the adjustment from the map, and landmarks with too few observations left; recomputes the
/// descriptors of the others. Skips what the map no longer has.
void drop_outliers(MapGraph& graph, const BundleProblem& problem);

}  // namespace rastro
