// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "rastro/map/graph/constraint.h"
#include "rastro/math/se2.h"
#include "rastro/math/se3.h"
#include "rastro/math/sim3.h"

namespace rastro {

/// How to treat edges that may be wrong: all but ConstraintKind::odometry.
enum class LoopModel : std::uint8_t {
  switchable,  ///< Each has a switch that turns it off at a price (SwitchKernel).
  robust,      ///< Cauchy's kernel: its influence is bounded.
  trusted,     ///< Like any other edge.
};

struct PoseGraphOptions {
  LoopModel loops = LoopModel::switchable;
  double switch_price = 30.0;  ///< Squared sigmas that turning an edge off costs; a correct one has 6 on average.
  double robust_width = 4.0;   ///< Width of Cauchy's kernel, sigmas.
  int iterations = 20;         ///< Maximum per stage.
  bool gradual = true;         ///< Introduces switches in stages; false: the switches decide from the first step on.
  bool fix_scale = false;      ///< Sim3: keeps the scales, as stereo and depth cameras measure them.
  /// Sim3: inverse variance of the log of an edge's scale, which Constraint::information does not include.
  double scale_information = 1.0;
};

struct PoseGraphResult {
  bool converged = false;
  double first_cost = 0.0, last_cost = 0.0;  ///< Half the sum of squared residuals in sigmas, after the kernels.
};

/// The type gives the space of the graph:
/// - SE2: the plane z = 0 (Konolige et al. 2010, "Sparse pose adjustment"). Only x, y and yaw of an edge count
///   (in_plane()).
/// - SE3: rigid motions in space. The scale of an edge is ignored.
/// - Sim3: with a scale per pose, for loops of one camera (Strasdat et al. 2010, "Scale drift-aware large scale
///   monocular SLAM").
template <typename Pose>
concept GraphPose = std::same_as<Pose, SE2> || std::same_as<Pose, SE3> || std::same_as<Pose, Sim3>;

/// Pose graph optimization: Levenberg-Marquardt in Ceres with a sparse factorization; one thread, so the same bytes on
/// every run. `from` and `to` of an edge are indices into `world_from_pose`. Poses whose `fixed` is nonzero stay, and
/// so do poses without edges. Edges between two fixed poses are skipped, so the cost for a window of a long run depends
/// on the window only. Sets `edges[i].weight` of each edge used to its weight by the kernel. Switches are introduced
/// gradually (Yang et al. 2020, "Graduated non-convexity"), so that a correct loop after a long drift is not rejected.
template <GraphPose Pose>
PoseGraphResult optimize_pose_graph(std::vector<Pose>& world_from_pose, std::span<Constraint> edges,
                                    std::span<const std::uint8_t> fixed, const PoseGraphOptions& options);

/// What optimize_pose_graph() takes for each edge while it runs, to plan memory with: residuals, derivatives, normal
/// equations and their factor. Measured with Ceres 2.1 on graphs of SE3 of 3,000 to 96,000 edges: 3,650 to 4,200 bytes.
inline constexpr std::size_t pose_graph_bytes_per_edge = 4200;

/// The residual of an edge at these poses: d of from_from_to * exp(d) = world_from_from^-1 * world_from_to. In the
/// plane it is not the logarithm but (x, y, yaw) of from_from_to^-1 * world_from_from^-1 * world_from_to.
template <GraphPose Pose>
typename Pose::Tangent edge_residual(const Constraint& edge, const Pose& world_from_from, const Pose& world_from_to);

/// The squared residual in sigmas.
template <GraphPose Pose>
double squared_sigmas(const Constraint& edge, const Pose& world_from_from, const Pose& world_from_to,
                      const PoseGraphOptions& options = {});

}  // namespace rastro
