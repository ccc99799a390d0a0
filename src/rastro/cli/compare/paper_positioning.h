// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "rastro/cli/compare/comparison.h"
#include "rastro/cli/compare/paired_differences.h"
#include "rastro/cli/compare/paper_table.h"

namespace rastro::cli {

/// Motion since a start, in the axes of the positioning paper: X forward, Y left, Z up of the vehicle there.
struct VehicleMotion {
  std::vector<double> times_s;
  std::vector<Eigen::Vector3d> positions_m;
  std::vector<Eigen::Vector3d> angles_deg;  ///< Roll, pitch, yaw (left is positive); yaw is not wrapped.
};

/// Of poses of the camera (x right, y down), or of a body whose axes are those of the paper, since `start`: one clock
/// and one frame for all methods, whichever frame they begin with.
VehicleMotion vehicle_motion(const Trajectory& poses, bool of_camera, const StampedPose& start);

/// Figures 9 to 14 of Mendieta and Moreyra, "Posicionamiento basado en una secuencia de imagenes": the positions and
/// angles of the odometries beside the ground truth. One per input without depth that has traces of them; of several
/// seeds or repeats the one with the median error.
std::vector<PaperTable> paper_positioning_tables(const Comparison& comparison, const std::vector<ColumnTrace>& traces);

}  // namespace rastro::cli
