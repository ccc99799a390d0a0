// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "rastro/base/task_pool.h"
#include "rastro/slam/orb/local_mapping/bundle_problem.h"
#include "rastro/slam/orb/map/map_graph.h"

namespace rastro {

/// Bundle adjustment of a whole submap beside mapping, which goes on meanwhile (Mur-Artal and Tardos 2017, section
/// III.C): a copy is taken, adjusted, and carried over to what the map has become.
class GlobalBundleAdjustment {
 public:
  GlobalBundleAdjustment(const MapGraph& graph, int submap, double pixel_sigma);

  std::size_t observations() const { return problem_.bundle.observations.size(); }
  /// The work; touches no map. Ends early once `stop` (may be null) is true or cancel() was called.
  void run(int iterations, const std::atomic<bool>* stop, TaskPool* pool);
  /// From any thread.
  void cancel() { cancelled_ = true; }
  /// Adjusted keyframes and landmarks go where adjustment brought them; what was made since moves with its ancestor in
  /// the spanning tree, or with the keyframe that made it.
  void apply(MapGraph& graph) const;
  /// What was done, for the log.
  std::string detail() const;

 private:
  BundleProblem problem_;  ///< Keyframes ascending.
  std::atomic<bool> cancelled_ = false;
};

}  // namespace rastro
