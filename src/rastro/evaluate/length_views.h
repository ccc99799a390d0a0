// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "rastro/evaluate/length_face.h"
#include "rastro/map/graph/map.h"

namespace rastro {

/// A place of the map that keyframes are chosen for.
struct LengthPlace {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< World.
  std::optional<Eigen::Vector3d> normal;  ///< Of the face there: keyframes that look at it squarely are better.
};

/// Ids of the keyframes that show the places best, in their order: up to `count` for each place, and up to `count`
/// that show both. Keyframes beside one another count for less. Whether something stands in between is not known here.
std::vector<KeyframeId> choose_views(const Map& map, const LengthPlace& a, const LengthPlace& b, int count);

/// Opens the images of a keyframe of a map with an image layer. Error where they cannot be read or are not of the
/// camera's size.
LengthView open_view(const Map& map, KeyframeId id);

}  // namespace rastro
