// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "rastro/map/graph/keyframe_id.h"
#include "rastro/math/se3.h"
#include "rastro/math/sim3.h"

namespace rastro {

/// The origin of a constraint. All but odometry may be wrong.
enum class ConstraintKind : std::uint8_t {
  odometry,     ///< Between consecutive keyframes.
  proximity,    ///< Matched to another keyframe of the neighborhood.
  loop,         ///< Loop closure: matched to a place visited much earlier.
  merge,        ///< Connects two submaps.
  inter_robot,  ///< Connects the maps of two robots.
};
constexpr int constraint_kinds = 5;
const char* name_of(ConstraintKind kind);  ///< "odometry", "proximity", ...

/// Relative pose of two keyframes, an edge of the pose graph. SE2 and SE3 are Sim3 with scale 1.
struct Constraint {
  KeyframeId from = 0, to = 0;
  Sim3 from_from_to = {};  ///< Maps points of camera (or body) `to` into that of `from`.
  /// Inverse covariance of d in ground truth = from_from_to * exp(d), (translation m, rotation rad).
  Matrix6d information = Matrix6d::Identity();
  ConstraintKind kind = ConstraintKind::odometry;
  double weight = 1.0;  ///< 0..1, weight by the robust kernel after the last optimization.
  int inliers = 0;      ///< Matches that agree with it; 0: unknown.
  /// Of the logarithm of its scale, on top of what all edges of a graph have in common (PoseGraphOptions). Not saved.
  double scale_variance = 0.0;

  SE3 rigid() const { return {from_from_to.rotation(), from_from_to.translation()}; }  ///< Without the scale.
};

/// What keeps a constraint out of any pose graph, as a clause such as "has a constraint whose numbers are not finite";
/// empty if nothing does.
std::string fault_of(const Constraint& constraint);

}  // namespace rastro
