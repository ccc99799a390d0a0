// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/sensor/trajectory.h"

namespace rastro {

/// What is known of two instants of a recording: where the body was at b, seen from where it was at a.
struct Relation {
  TimeNs stamp_a = 0, stamp_b = 0;
  SE3 a_from_b;
};

/// Lines of "stamp_a stamp_b x y z roll pitch yaw": seconds, metres, radians, the rotation as yaw * pitch * roll; '#'
/// begins a comment. Error naming the line for anything else, and for a text without a relation.
std::vector<Relation> parse_relations(std::string_view text, std::string_view where);

/// Mean and standard deviation over the relations that could be held against the trajectory.
struct RelationScores {
  std::int64_t relations = 0;  ///< Held against the trajectory.
  std::int64_t skipped = 0;    ///< One of their instants has no pose near enough.
  double trans_mean_m = 0.0, trans_sigma_m = 0.0;
  double rot_mean_deg = 0.0, rot_sigma_deg = 0.0;
  double worst_trans_m = 0.0;
  TimeNs worst_dt = 0;  ///< The largest difference of stamps that was accepted.
};

/// Kuemmerle et al. 2009, "On measuring the accuracy of SLAM algorithms": the error of a relation is
/// relation^-1 * (estimate_a^-1 * estimate_b); its translation's length and its rotation's angle are averaged. No
/// alignment is needed and no place counts more for having been reached late. Each instant takes the pose whose stamp
/// is nearest, if that is within `max_difference`. `trajectory` is in the order of time.
RelationScores score_relations(const std::vector<Relation>& relations, const Trajectory& trajectory,
                               TimeNs max_difference);

}  // namespace rastro
