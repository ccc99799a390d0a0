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

/// A part of the map as bundle adjustment takes it: a copy, so that the map may change meanwhile.
struct BundleProblem {
  using Seen = std::pair<std::int64_t, std::int64_t>;  ///< A keyframe and a landmark it observes.

  Bundle bundle;
  std::vector<std::int64_t> keyframes, landmarks;  ///< What each camera and point of the bundle stands for.
  std::vector<Seen> seen;                          ///< One an observation.
  std::vector<Seen> outliers;                      ///< Taken out by adjust_bundle_problem().
};

/// The landmarks seen by the keyframes of `free`, and who of both lists observes them; `fixed` stays. `pixel_sigma`:
/// standard deviation of a feature's place at the finest level, pixels.
BundleProblem bundle_problem(const MapGraph& graph, const std::vector<std::int64_t>& free,
                             const std::vector<std::int64_t>& fixed, double pixel_sigma);

/// Two rounds of at most half of `iterations`, then all of them; observations beyond 95 % of chi-square go after each.
/// Ends early once `stopped` (may be empty) is true.
void adjust_bundle_problem(BundleProblem& problem, int iterations, const std::function<bool()>& stopped,
                           TaskPool* pool);

/// Takes out of the map what adjustment took for outliers, and landmarks with too few observations left; describes the
/// others anew. Parts that the map no longer has are left alone.
void drop_outliers(MapGraph& graph, const BundleProblem& problem);

}  // namespace rastro
