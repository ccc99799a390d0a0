// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "rastro/sensor/trajectory.h"
#include "rastro/sensor/trajectory_file.h"

namespace rastro {

/// A trajectory to be scored, or to score against, with information on its file.
struct TrajectoryInput {
  std::string file;
  TrajectoryFormat format = TrajectoryFormat::tum;
  Trajectory poses;  ///< In the order of time; those of a KITTI file in the order of its lines.
  /// The same poses with the rotations as written in the file: published figures are computed from these.
  std::vector<Eigen::Matrix4d> matrices;
  bool has_stamps = true;     ///< False: a KITTI file without a times file; pose k is stamped k seconds.
  bool of_recording = false;  ///< Made from other files of a recording (GPS/IMU packets); `format` has no meaning.
  std::string stamps_from;    ///< As text: "in ns", "of times.txt, in s"; empty without stamps.
};

/// Reads TUM, KITTI or EuRoC text and detects the format and the unit of the stamps. KITTI poses take their stamps from
/// `times_file`, or from STEM_times.txt or times.txt beside the file if there is one that is long enough. Throws Error
/// as in trajectory_file.h; also for a times file that is too short or whose stamps do not increase.
TrajectoryInput read_trajectory_input(const std::string& file, const std::string& times_file = "");

/// The poses of `trajectory`, from `file` or computed by the program.
TrajectoryInput trajectory_input_from(Trajectory trajectory, const std::string& file);

/// As text: "poses.txt (KITTI, 4541 poses, stamps of times.txt, in s)".
std::string describe(const TrajectoryInput& input);

}  // namespace rastro
