// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "rastro/evaluate/length_face.h"
#include "rastro/map/keyframe/rgbd_map.h"

namespace rastro {

/// A place of the map that keyframes are chosen for.
struct LengthPlace {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< World.
  std::optional<Eigen::Vector3d> normal;  ///< Of the face there: keyframes that look at it squarely are better.
};

/// Numbers of the keyframes that show the places best, in their order: up to `count` for each place, and up to `count`
/// that show both. Keyframes beside one another count for less. Whether something stands in between is not known here.
std::vector<std::int64_t> choose_views(const RgbdMap& map, const LengthPlace& a, const LengthPlace& b, int count);

/// Opens the pictures of a keyframe. Error where they cannot be read or are not of the camera's size.
LengthView open_view(const RgbdMap& map, std::int64_t keyframe);

}  // namespace rastro
