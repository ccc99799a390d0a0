// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "rastro/multiview/point_pairs.h"

namespace rastro {

/// Whether a point's motion a -> b agrees within `max_error` pixels with that of its nearest neighbors (in image a).
/// The similarity with the most inliers among the nearest dozen matches is found by exhaustive search over pairs of
/// them. The point's own match (same position in both images) is left out. For scenes with depth, where no single plane
/// explains the image but neighbors have the same motion.
bool agrees_with_neighbors(const PointPairs& pairs, const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                           double max_error);

}  // namespace rastro
