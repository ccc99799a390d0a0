// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/map/grid/occupancy_grid.h"
#include "rastro/map/keyframe/rgbd_map.h"
#include "rastro/map/landmark/landmark_map.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

/// A landmark of a planar map with what is known of its place.
struct PlanarLandmark {
  std::int64_t id = 0;                                       ///< The map's own, in order of creation.
  std::int64_t sensor_id = -1;                               ///< As the sensor names it, else -1.
  Eigen::Vector2d position = Eigen::Vector2d::Zero();        ///< World, metres.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  ///< m^2
  int observations = 0;
};

/// Two keyframes and why they are tied together.
struct GraphEdge {
  std::size_t from = 0, to = 0;  ///< Into Snapshot::keyframes.
  bool loop = false;             ///< False: from one to the next along the way.
};

/// A view of a method's map that never changes. What a method does not have stays empty.
struct Snapshot {
  std::int64_t revision = 0;  ///< Grows with each change of the map.
  std::shared_ptr<const OccupancyGrid> grid;
  std::vector<PlanarLandmark> landmarks;
  std::shared_ptr<const RgbdMap> rgbd;
  std::shared_ptr<const LandmarkMap> landmark_map;
  Trajectory keyframes;  ///< world_from_body
  std::vector<GraphEdge> edges;
};

}  // namespace rastro
