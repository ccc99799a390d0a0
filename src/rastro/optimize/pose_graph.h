// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rastro/map/graph/constraint.h"
#include "rastro/math/se3.h"

namespace rastro {

/// What is done about ties that may be wrong: all but ConstraintKind::odometry.
enum class LoopModel : std::uint8_t {
  switchable,  ///< Each has a switch that turns it off at a price (Suenderhauf and Protzel 2012).
  robust,      ///< Cauchy's kernel: its pull grows no more.
  trusted,     ///< As sure as any.
};

struct PoseGraphOptions {
  LoopModel loops = LoopModel::switchable;
  double switch_price = 30.0;  ///< Squared sigmas that turning one off costs; 6 is what a right one has on average.
  double robust_width = 4.0;   ///< Sigmas from which Cauchy's kernel bends.
  int iterations = 20;         ///< At most, of each stage.
};

struct PoseGraphResult {
  bool converged = false;
  double first_cost = 0.0, last_cost = 0.0;  ///< Half the sum of squared sigmas, kernels included.
};

/// Moves the poses until the edges fit: Levenberg-Marquardt in Ceres with a sparse factorisation; one thread, so the
/// same bytes on every run. Poses whose `fixed` is not zero stay, and so does what no edge holds; edges between two
/// fixed poses are not looked at, so that a window of a long run costs what the window costs. `edges[i].weight` is set
/// to what the kernel left of each edge looked at.
/// Switches are eliminated in closed form (Agarwal et al. 2013, "Robust map optimization using dynamic covariance
/// scaling") and brought in by degrees (Yang et al. 2020, "Graduated non-convexity"), so that a true loop after a long
/// drift is not taken for a wrong one.
PoseGraphResult optimize_pose_graph(std::vector<SE3>& world_from_pose, std::span<Constraint> edges,
                                    std::span<const std::uint8_t> fixed, const PoseGraphOptions& options);

/// The d of the edge's truth = from_from_to * exp(d) for these poses.
Vector6d pose_edge_error(const Constraint& edge, const SE3& world_from_from, const SE3& world_from_to);
/// Squared error in sigmas.
double squared_sigmas(const Constraint& edge, const SE3& world_from_from, const SE3& world_from_to);

}  // namespace rastro
