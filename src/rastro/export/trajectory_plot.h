// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "rastro/math/se3.h"

namespace rastro {

/// An estimate in the reference's world, pose by pose of the reference's it is compared with.
struct PlottedEstimate {
  std::string name;
  std::vector<std::size_t> reference_index;
  std::vector<SE3> poses;
};

/// What a plot of trajectories shows: x, y, z (meters) and roll, pitch, yaw (degrees, of the rotation since the
/// reference's first pose) of reference and estimates, their errors (estimate minus reference), and the path from
/// above.
struct TrajectoryPlot {
  std::string title;
  std::string along_label;    ///< What `along` is: "frame" or "time [s]".
  std::vector<double> along;  ///< Of each pose of the reference.
  std::vector<SE3> reference;
  std::vector<PlottedEstimate> estimates;
  /// The poses are a camera's (x right, y down, z forward: yaw rotates about y, pitch about x, roll about z, in this
  /// order); otherwise a body's (x forward, z up: yaw about z, pitch about y, roll about x).
  bool camera_axes = true;
  /// Seen from above, the world is its x-z plane, as where the first camera is the world; otherwise its x-y plane.
  bool y_is_down = true;
};

/// Error unless the name ends in .svg or .png: for checking before the work is done.
void require_plot_name(const std::string& file);

/// Draws the plot into a file, whose ending says how: .svg or .png. Error as above, and where it cannot be written.
void write_trajectory_plot(const TrajectoryPlot& plot, const std::string& file);

}  // namespace rastro
