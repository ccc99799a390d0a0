// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "rastro/backend/rgbd/keyframe_graph.h"

namespace rastro {

/// A constraint that nothing else in the graph supports, and what it rests on.
struct LoopHypothesis {
  Constraint edge;
  Eigen::Vector3d evidence = Eigen::Vector3d::Zero();  ///< Center of the surfaces that look alike, in camera edge.to.
};

/// Whether a pose is so near to the one that the map predicts that the map itself speaks for it. A loop closure is
/// wrong from 0.5 m on, so that a wrong one hardly is.
bool agrees_with_map(const SE3& predicted, const SE3& measured);

/// One door looks like another, but hardly two things in a row: a hypothesis counts when the path shortly before has
/// another, of another keyframe, that rests on surfaces elsewhere and would correct the map alike where either was
/// found (Olson 2009, pairwise consistency). Not thread-safe.
class LoopConfirmation {
 public:
  using Fits = std::function<bool(const Constraint&)>;
  /// The constraints that are confirmed now, with the newest among them; none where it has to wait for another.
  /// `still_fits`: whether the map as it is now allows an earlier one, which is dropped otherwise.
  std::vector<Constraint> next(const KeyframeGraph& graph, const LoopHypothesis& newest, const Fits& still_fits);

 private:
  std::vector<LoopHypothesis> waiting_;
};

}  // namespace rastro
