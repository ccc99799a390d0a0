// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "rastro/map/grid/log_odds_model.h"
#include "rastro/map/grid/occupancy_grid.h"
#include "rastro/map/keyframe_layer.h"

namespace rastro {

/// The returns of one laser scan and the laser's position; meters, in the body frame of its keyframe.
struct KeyframeScan {
  Eigen::Vector2d sensor = Eigen::Vector2d::Zero();
  std::vector<Eigen::Vector2d> points;
};
/// The scans of a keyframe: its own, and those up to the next keyframe if the method inserts these into the grid too.
using KeyframeScans = std::vector<KeyframeScan>;

/// Laser scans of a planar map, and the parameters of its occupancy grid.
struct ScanLayer : KeyframeLayer<KeyframeScans> {
  static constexpr const char* layer_name = "scans";
  double cell_m = 0.05;
  LogOddsModel model;
};

/// The occupancy grid of the scans of a submap at the current poses of their keyframes; nullopt where it has no scans.
std::optional<OccupancyGrid> occupancy_grid_of(const Map& map, int submap = 0);

std::unique_ptr<LayerType> scans_layer_type();

}  // namespace rastro
