// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "rastro/map/graph/map.h"

namespace rastro {

/// A feature of one keyframe.
struct FeatureView {
  std::size_t keyframe = 0, feature = 0;  ///< Index into Map::keyframes, and into the features of that keyframe.
};

/// A point in the world that features of several keyframes observe.
struct FeaturePoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< World, meters.
  double error_px = 0.0;                               ///< Mean reprojection error, pixels.
  std::vector<FeatureView> views;                      ///< At least two, of different keyframes, in order.
};

/// Groups features with similar descriptors whose depths give the same position, keyframe by keyframe. `submap` as in
/// CloudOptions.
std::vector<FeaturePoint> feature_points(const Map& map, int submap = 0);

}  // namespace rastro
