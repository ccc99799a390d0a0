// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "rastro/map/keyframe/rgbd_map.h"
#include "rastro/map/landmark/landmark_map.h"
#include "rastro/sensor/trajectory.h"

namespace rastro::cli {

/// What `rastro export` is given: the folder of a run, a map file, or a file of poses.
struct ExportInput {
  std::string path;
  std::shared_ptr<const RgbdMap> map;               ///< Null where there is none.
  std::shared_ptr<const LandmarkMap> landmark_map;  ///< The same; never both.
  Trajectory trajectory;                            ///< Of every frame with a pose; empty where there is none.
};

/// Error where `path` is none of the three, or cannot be read.
ExportInput read_export_input(const std::string& path);

/// The map, or an Error that says what the input has instead.
const RgbdMap& need_map(const ExportInput& input, const std::string& kind);
const LandmarkMap& need_landmark_map(const ExportInput& input, const std::string& kind);
const Trajectory& need_trajectory(const ExportInput& input, const std::string& kind);

}  // namespace rastro::cli
