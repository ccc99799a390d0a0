// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "rastro/math/se3.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

/// Covariance of a pose world_from_body: translation (m), then rotation (rad), both in the world's axes.
struct StampedCovariance {
  TimeNs stamp = 0;
  Matrix6d covariance = Matrix6d::Zero();
};

/// Lines of 'stamp and 21 numbers', the upper triangle row by row, as runs write them (covariance_online.txt). Error
/// with the line for anything else; `where` names the file.
std::vector<StampedCovariance> parse_pose_covariances(std::string_view text, std::string_view where);

/// Whether errors are as large as their covariances say, of positions or of rotations.
struct ConsistencyOfPart {
  int poses = 0;
  double inside_percent = 0.0;  ///< Inside the ellipse that is to hold 95 %.
  double nees = 0.0;            ///< Mean normalized squared error for each degree of freedom; 1 is right.
  double sigma_factor = 0.0;    ///< The sigmas would hold 95 % of the errors if they were this many times as large.
};

struct PoseConsistency {
  std::optional<ConsistencyOfPart> position, rotation;  ///< nullopt: no pose has a covariance there.
};

/// Poses as they were first given, with their covariances, beside a reference.
struct ConsistencyInput {
  const Trajectory& reference;
  const Trajectory& final_poses;                      ///< Of the run's end; contain its origin.
  const Trajectory& first_poses;                      ///< What the covariances are of.
  const std::vector<StampedCovariance>& covariances;  ///< In the order of time.
  double scale = 1.0;                                 ///< Units of the reference per unit of the estimate.
  TimeNs max_difference = 0;  ///< From a pose to those of the reference, which are interpolated.
};

/// Normalized estimation error squared (Bar-Shalom, Li and Kirubarajan 2001, section 5.4). A run knows its poses
/// relative to where it began, so both sides coincide there: at the final pose that is the identity, else at the first.
/// Where no final pose has a covariance, they are of another submap, and it is such a pose of `first_poses`.
/// Directions of variance 0 (height and tilt of motion in the plane) are no degrees of freedom.
PoseConsistency score_consistency(const ConsistencyInput& input);

}  // namespace rastro
