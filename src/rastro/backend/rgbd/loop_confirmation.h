// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "rastro/backend/rgbd/keyframe_graph.h"

namespace rastro {

/// A constraint that nothing else in the graph supports, and what it rests on.
struct LoopHypothesis {
  Constraint edge;
  Eigen::Vector3d evidence = Eigen::Vector3d::Zero();  ///< Center of the surfaces that look alike, in camera edge.to.
};

/// One door looks like another, but hardly two things in a row: a hypothesis counts when the path shortly before has
/// another that rests on surfaces elsewhere and would correct the map alike (Olson 2009, pairwise consistency). Not
/// thread-safe.
class LoopConfirmation {
 public:
  /// The constraints that are confirmed now, with the newest among them; none where it has to wait for another.
  std::vector<Constraint> next(const KeyframeGraph& graph, const LoopHypothesis& newest);

 private:
  std::vector<LoopHypothesis> waiting_;
};

}  // namespace rastro
