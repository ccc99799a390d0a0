// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "rastro/export/trajectory_plot.h"

namespace rastro {

/// x, y, z in meters, then roll, pitch, yaw in degrees since the reference's first pose.
using TrajectoryRow = std::array<double, 6>;

/// Of an estimate's poses; angles run on beyond 180 degrees with the reference's.
struct EstimateCurves {
  std::vector<TrajectoryRow> values, errors;  ///< Error: estimate minus reference.
};

/// What a plot of trajectories draws.
struct TrajectoryCurves {
  std::vector<TrajectoryRow> reference;
  std::vector<EstimateCurves> estimates;
};

TrajectoryCurves curves_of(const TrajectoryPlot& plot);

/// One line per pose of each estimate: its name, frame or time, values and errors.
std::string trajectory_curves_as_csv(const TrajectoryPlot& plot);

}  // namespace rastro
