// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "rastro/sensor/trajectory.h"
#include "rastro/sensor/trajectory_file.h"

namespace rastro {

/// A trajectory to be scored, or to score against, with what its file says of itself.
struct TrajectoryInput {
  std::string file;
  TrajectoryFormat format = TrajectoryFormat::tum;
  Trajectory poses;  ///< In the order of time; those of a KITTI file in the order of its lines.
  /// The same poses, the rotations no better than the digits of the file: published figures are made of these.
  std::vector<Eigen::Matrix4d> matrices;
  bool has_stamps = true;     ///< False: a KITTI file without stamps beside it; pose k is stamped k seconds.
  bool of_recording = false;  ///< Made from other files of a recording (GPS/IMU packets); `format` says nothing.
  std::string stamps_from;    ///< For people: "in ns", "of times.txt, in s"; empty without stamps.
};

/// Reads TUM, KITTI or EuRoC text, guessing which, and guesses the unit of the stamps. KITTI poses take their stamps
/// from `times_file`, or from STEM_times.txt or times.txt beside the file where there is one that is long enough. Error
/// as trajectory_file.h says; also for a times file that is too short or whose stamps do not grow.
TrajectoryInput read_trajectory_input(const std::string& file, const std::string& times_file = "");

/// The poses of `trajectory`, kept in `file` or made by the program.
TrajectoryInput trajectory_input_from(Trajectory trajectory, const std::string& file);

/// "poses.txt (KITTI, 4541 poses, stamps of times.txt, in s)".
std::string describe(const TrajectoryInput& input);

}  // namespace rastro
