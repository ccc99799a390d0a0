// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "rastro/map/grid/log_odds_grid.h"
#include "rastro/map/grid/occupancy_grid.h"
#include "rastro/map/keyframe_layer.h"

namespace rastro {

/// The returns of one laser scan, and where the laser stood; metres, in the body frame of its keyframe.
struct KeyframeScan {
  Eigen::Vector2d sensor = Eigen::Vector2d::Zero();
  std::vector<Eigen::Vector2d> points;
};
/// The scans of a keyframe: its own, and those up to the next keyframe where a method puts them into the grid too.
using KeyframeScans = std::vector<KeyframeScan>;

/// Laser scans of a planar map, and how they become an occupancy grid.
struct ScanLayer : KeyframeLayer<KeyframeScans> {
  static constexpr const char* layer_name = "scans";
  double cell_m = 0.05;
  LogOddsModel model;
};

/// The occupancy grid of the scans of a submap where the map has their keyframes now; nullopt where it has no scans.
std::optional<OccupancyGrid> occupancy_grid_of(const Map& map, int submap = 0);

std::unique_ptr<LayerType> scans_layer_type();

}  // namespace rastro
