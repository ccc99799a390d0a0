// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "rastro/map/snapshot.h"

namespace rastro {

/// A place and how well it is known.
struct PlaceEllipse {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();      ///< World, metres.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< m^2
};

/// What is drawn of a planar map, from above: x to the right, y up. Anything may be missing.
struct MapPicture {
  std::shared_ptr<const OccupancyGrid> grid;
  std::vector<Eigen::Vector2d> path;       ///< In the order of time.
  std::vector<Eigen::Vector2d> keyframes;  ///< Dots.
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> loops;
  std::vector<PlaceEllipse> landmarks;  ///< Crosses with their 95 % ellipses.
  std::vector<PlaceEllipse> places;     ///< 95 % ellipses along the path.
};

/// The picture of a method's map with the way that led through it.
MapPicture map_picture(const Snapshot& map, const Trajectory& trajectory);

/// A PNG of at most 1600 pixels a side: walls black, free cells white, the rest grey, path blue from the green start to
/// the red end, loop closures orange, with a bar of 1 m (10 m, ... for large maps).
void write_map_picture(const MapPicture& picture, const std::string& file);

}  // namespace rastro
