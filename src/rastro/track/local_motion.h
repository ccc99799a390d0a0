// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "rastro/multiview/point_pairs.h"

namespace rastro {

/// Whether a point's motion a -> b agrees with that of its nearest neighbours (in image a) within `max_error` pixels:
/// the similarity that most of the nearest dozen pairs share is searched exhaustively over their pairs. The point's own
/// pair (same place in both images) has no say. For scenes with depth, where no single plane explains the image but
/// neighbours move alike.
bool agrees_with_neighbours(const PointPairs& pairs, const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                            double max_error);

}  // namespace rastro
