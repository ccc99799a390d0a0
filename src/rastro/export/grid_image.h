// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "rastro/map/graph/map.h"
#include "rastro/map/grid/occupancy_grid.h"

namespace rastro {

/// A position and how well it is known.
struct PositionEllipse {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();      ///< World, meters.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< m^2
};

/// What is drawn of a planar map, from above: x to the right, y up. Anything may be missing.
struct MapImage {
  std::shared_ptr<const OccupancyGrid> grid;
  std::vector<Eigen::Vector2d> path;                               ///< In the order of time.
  std::vector<Eigen::Vector2d> keyframes;                          ///< Dots.
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> loops;  ///< Of those alike one is drawn.
  std::vector<PositionEllipse> landmarks;                          ///< Crosses with their 95 % ellipses.
  std::vector<PositionEllipse> positions;                          ///< 95 % ellipses along the path.
};

/// Submap 0 of a planar map with a trajectory through it: `grid` is occupancy_grid_of(map) (null: none), landmarks are
/// those with estimates. Of the loop closures those count whose keyframes have a path
/// between them of at least twice their distance: others connect neighbors.
MapImage map_image(const Map& map, std::shared_ptr<const OccupancyGrid> grid, const Trajectory& trajectory);

/// A PNG of at most 1600 pixels a side: walls black, free cells white, the rest gray, path blue from the green start to
/// the red end, loop closures orange, with a bar of 1 m (10 m, ... for large maps).
void write_map_image(const MapImage& image, const std::string& file);

}  // namespace rastro
