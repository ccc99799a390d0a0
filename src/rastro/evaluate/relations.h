// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/sensor/trajectory.h"

namespace rastro {

/// Known relative pose of two instants of a recording: the body's pose at b in the body's frame at a.
struct Relation {
  TimeNs stamp_a = 0, stamp_b = 0;
  SE3 a_from_b;
};

/// Lines of "stamp_a stamp_b x y z roll pitch yaw": seconds, meters, radians, the rotation as yaw * pitch * roll; '#'
/// begins a comment. Throws Error naming the line for anything else, and for a text without a relation.
std::vector<Relation> parse_relations(std::string_view text, std::string_view where);

/// Mean and standard deviation over the relations compared with the trajectory.
struct RelationScores {
  std::int64_t relations = 0;  ///< Compared with the trajectory.
  std::int64_t skipped = 0;    ///< One of their instants has no pose close enough.
  double trans_mean_m = 0.0, trans_sigma_m = 0.0;
  double rot_mean_deg = 0.0, rot_sigma_deg = 0.0;
  double worst_trans_m = 0.0;
  TimeNs worst_dt = 0;  ///< The largest accepted difference of stamps.
};

/// Kuemmerle et al. 2009, "On measuring the accuracy of SLAM algorithms": the error of a relation is relation^-1 *
/// (estimate_a^-1 * estimate_b); its translation's length and its rotation's angle are averaged. No alignment is needed
/// and late poses count no more than early ones. Each instant uses the pose with the nearest stamp, if that is within
/// `max_difference`. `trajectory` is in the order of time.
RelationScores score_relations(const std::vector<Relation>& relations, const Trajectory& trajectory,
                               TimeNs max_difference);

}  // namespace rastro
