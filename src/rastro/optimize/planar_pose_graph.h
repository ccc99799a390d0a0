// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "rastro/math/se2.h"

namespace rastro {

/// Pose b as seen from a, with what is known of it.
struct PlanarEdge {
  std::size_t a = 0, b = 0;
  SE2 a_from_b;
  /// Upper triangular square root of the information: squared error = |root * (x, y, angle)|^2, (x, y) in a's frame.
  Eigen::Matrix3d root_information = Eigen::Matrix3d::Identity();
  bool robust = false;  ///< May be wrong: beyond `robust_width` sigmas its pull stops growing.
};

struct PlanarPoseGraphOptions {
  double robust_width = 2.0;  ///< Sigmas from which an edge marked robust loses its pull (Cauchy).
  int iterations = 50;
};

struct PlanarPoseGraphResult {
  bool converged = false;
  double first_cost = 0.0, last_cost = 0.0;
};

/// Moves the poses until the edges fit: Levenberg-Marquardt with a sparse factorisation (Konolige et al. 2010, Sparse
/// Pose Adjustment). Pose 0 stays, and so does what no edge ties to it. One thread: the same bytes on every run.
PlanarPoseGraphResult optimize_planar_pose_graph(std::vector<SE2>& world_from_pose,
                                                 const std::vector<PlanarEdge>& edges,
                                                 const PlanarPoseGraphOptions& options);

/// Error of one edge in its own sigmas (x, y in a's frame, angle).
Eigen::Vector3d planar_edge_error(const PlanarEdge& edge, const SE2& world_from_a, const SE2& world_from_b);

}  // namespace rastro
