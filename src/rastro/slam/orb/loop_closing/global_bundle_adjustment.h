// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "rastro/base/task_pool.h"
#include "rastro/slam/orb/local_mapping/bundle_problem.h"
#include "rastro/slam/orb/map/map_graph.h"

namespace rastro {

/// Bundle adjustment of a whole submap beside mapping, which continues meanwhile (Mur-Artal and Tardos 2017, section
/// III.C): a copy is taken and adjusted, and the result is applied to the current map.
class GlobalBundleAdjustment {
 public:
  GlobalBundleAdjustment(const MapGraph& graph, int submap, double pixel_sigma);

  std::size_t observations() const { return problem_.bundle.observations.size(); }
  /// Runs the adjustment; accesses no map. Stops early once `stop` (may be null) is true or cancel() was called.
  void run(int iterations, const std::atomic<bool>* stop, TaskPool* pool);
  /// From any thread.
  void cancel() { canceled_ = true; }
  /// Applies the adjusted keyframes and landmarks. Keyframes made since move with their ancestor in the
  /// spanning tree, landmarks with the keyframe that created them.
  void apply(MapGraph& graph) const;
  /// A summary for the log.
  std::string detail() const;

 private:
  BundleProblem problem_;  ///< Keyframes ascending.
  std::atomic<bool> canceled_ = false;
};

}  // namespace rastro
