// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/sensor/stamp_text.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

enum class TrajectoryFormat {
  // Where a line names the columns before the first pose, their order is that.
  tum,    ///< "stamp tx ty tz qx qy qz qw", seconds, spaces.
  euroc,  ///< "stamp,px,py,pz,qw,qx,qy,qz[,...]", nanoseconds, commas.
  kitti,  ///< 12 numbers per line, the upper 3x4 of the pose, row by row; no stamps.
};

// Parsers of text. Each throws Error naming `where`:line for: a wrong number of columns, anything that is not a finite
// number, a quaternion more than 10 % from unit length, a 3x3 block that is not a rotation within 0.02, nothing but
// comments. Poses are sorted by stamp; of equal stamps the first is kept, as evaluators do. `unit` is that of the
// stamps.
Trajectory parse_tum_trajectory(std::string_view text, std::string_view where, StampUnit unit = StampUnit::seconds);
Trajectory parse_euroc_trajectory(std::string_view text, std::string_view where,
                                  StampUnit unit = StampUnit::nanoseconds);
/// Row k is the pose of frame k.
std::vector<SE3> parse_kitti_poses(std::string_view text, std::string_view where);
/// The same without normalization: rotations are as exact as the file's digits.
std::vector<Eigen::Matrix4d> parse_kitti_matrices(std::string_view text, std::string_view where);
/// KITTI's times.txt: one stamp in seconds per line.
std::vector<TimeNs> parse_kitti_times(std::string_view text, std::string_view where,
                                      StampUnit unit = StampUnit::seconds);
/// The unit of the stamps in the first column, see guess_stamp_unit().
StampUnit guess_column_unit(std::string_view text, StampUnit native);

/// Format by the first non-empty line; throws Error if it matches none of the three.
TrajectoryFormat guess_trajectory_format(std::string_view text, std::string_view where);

/// Reads a trajectory of any of the formats. KITTI poses take their stamps from `times_file`, or from FILE_times.txt or
/// times.txt beside the file if there is one and it is long enough; otherwise frame k is stamped k seconds.
Trajectory read_trajectory(const std::string& file, const std::string& times_file = "");

}  // namespace rastro
