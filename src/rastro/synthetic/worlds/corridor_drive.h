// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/math/se2.h"

namespace rastro::corridor {

/// Trajectory of a wheeled robot on the office floor: from the start once around the loop of corridors, in at one door
/// of the meeting room and out at the other, back to the start and `overlap_m` farther. It starts and ends at rest,
/// slows down for turns and never turns in place. The world's origin is the start, x ahead, y left.
class Drive {
 public:
  Drive();

  double length_m() const { return length_m_; }
  double duration_s() const { return arrivals_.back(); }
  /// Time at which the robot is back at its start.
  double loop_end_s() const;
  /// At rest before the beginning and after the end.
  double path_at(double time_s) const;
  SE2 pose_at_distance(double path_m) const;
  SE2 world_from_body(double time_s) const { return pose_at_distance(path_at(time_s)); }

 private:
  /// A straight and the turn to the left (1) or right (-1) after it; 0 at the end.
  struct Leg {
    SE2 world_from_begin;
    double begin_m = 0.0, straight_m = 0.0;
    int turn = 0;
  };

  void make_turn();
  void make_legs();
  void make_arrivals();
  /// Position along a turn to the left or right, relative to its beginning.
  SE2 in_turn(double path_m, int side) const;

  double turn_reach_ = 0.0;  ///< From a corner of the path to the begin and end of its turn.
  double length_m_ = 0.0;
  std::vector<Eigen::Vector3d> turn_;  ///< x, y and heading, evenly spaced along one turn to the left.
  std::vector<Leg> legs_;
  std::vector<double> arrivals_;  ///< Seconds at evenly spaced points of the path.
};

constexpr double overlap_m = 10.0;                    ///< Driven again after the loop.
constexpr double most_speed = 0.55, yaw_rate = 0.30;  ///< m/s
constexpr double robot_radius_m = 0.25;

}  // namespace rastro::corridor
