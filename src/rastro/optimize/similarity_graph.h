// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rastro/math/sim3.h"

namespace rastro {

/// What is known of one pose from another.
struct SimilarityEdge {
  std::uint32_t from = 0, to = 0;  ///< Indices of poses.
  Sim3 from_from_to;
  double weight = 1.0;  ///< Of the squared error.
};

struct SimilarityGraphOptions {
  bool fix_scale = false;  ///< Scales stay as they are: stereo and depth cameras know them.
  int iterations = 20;     ///< At most.
};

struct SimilarityGraphResult {
  bool converged = false;
  double first_cost = 0.0, last_cost = 0.0;  ///< Half the weighted sum of squared tangent vectors.
};

/// Moves the poses until the edges fit (Strasdat et al. 2010, "Scale drift-aware large scale monocular SLAM"): the
/// error of an edge is log(from_from_to^-1 * world_from_from^-1 * world_from_to). Levenberg-Marquardt in Ceres with a
/// sparse factorisation; one thread, so the same bytes on every run. Poses whose `fixed` is not zero stay, and so does
/// what no edge holds.
SimilarityGraphResult optimize_similarity_graph(std::vector<Sim3>& world_from_pose,
                                                std::span<const SimilarityEdge> edges,
                                                std::span<const std::uint8_t> fixed,
                                                const SimilarityGraphOptions& options);

}  // namespace rastro
