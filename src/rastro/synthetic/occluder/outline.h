// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "rastro/synthetic/occluder/occluder_tile.h"

namespace rastro {

enum class OccluderPart { skin, hair, shirt, trousers, post };

/// Position of a point relative to an occluder's outline.
struct OutlineDistance {
  double distance = 0.0;  ///< Signed distance to the outline, below 0 inside; in units of the occluder's width.
  OccluderPart part = OccluderPart::post;
};

/// The outline in units of the occluder's width: x to the right from the middle, y down from the image's top edge.
/// `sway` (-1 to 1) moves the figure's arms and legs.
OutlineDistance outline_distance(OccluderShape shape, const Eigen::Vector2d& position, double sway);

}  // namespace rastro
