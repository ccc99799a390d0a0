// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "rastro/evaluate/length_face.h"
#include "rastro/map/graph/map.h"

namespace rastro {

/// A point of the map for which keyframes are selected.
struct LengthPosition {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< World.
  std::optional<Eigen::Vector3d> normal;            ///< Of the face there: a frontal view is better.
};

/// Ids of the keyframes with the best views of the points, in their order: up to `count` for each point, and up to
/// `count` that show both. Neighboring keyframes count less. Occlusions are not checked.
std::vector<KeyframeId> choose_views(const Map& map, const LengthPosition& a, const LengthPosition& b, int count);

/// Loads the images of a keyframe of a map with an image layer. Throws Error if they cannot be read or do not have the
/// camera's size.
LengthView open_view(const Map& map, KeyframeId id);

}  // namespace rastro
