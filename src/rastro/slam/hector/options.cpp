// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/options.h"

namespace rastro {
namespace {

void add_method_options(OptionTable& table, HectorOptions& o) {
  table.add({"guess",
             &o.guess,
             "",
             "initial guess of a scan's pose: wheel odometry (constant velocity if there is none), constant velocity, "
             "or the pose of the last scan (as in the paper)",
             0,
             0,
             {"odometry", "constant-velocity", "none"}});
  table.add({"loop_closing",
             &o.loop_closing,
             "",
             "detect loops and correct the map, which scan matching alone cannot; false: one map, as in the paper",
             0,
             1,
             {}});
}

void add_scan_options(OptionTable& table, HectorOptions& o) {
  table.add({"min_range_m",
             &o.min_range_m,
             "m",
             "nearer returns are ignored, such as those of the robot itself",
             0,
             100,
             {}});
  table.add({"max_range_m",
             &o.max_range_m,
             "m",
             "farther returns are ignored; few scanners are reliable beyond 30 m",
             0.1,
             1000,
             {}});
  table.add({"min_returns", &o.min_returns, "", "number of returns that a pose needs", 3, 10000, {}});
}

void add_map_options(OptionTable& table, HectorOptions& o) {
  table.add({"cell_m", &o.cell_m, "m", "cell size of the finest level", 0.005, 1, {}});
  table.add({"levels",
             &o.levels,
             "",
             "resolution levels, each with twice the cell size of the one before; 3 as in the paper",
             1,
             6,
             {}});
  table.add({"occupied_probability",
             &o.occupied_probability,
             "",
             "occupancy of a cell with a return, from one scan; 0.9 as in the paper",
             0.51,
             0.99,
             {}});
  table.add({"free_probability",
             &o.free_probability,
             "",
             "occupancy of a cell that a beam passed, from one scan; 0.4 as in the paper",
             0.01,
             0.49,
             {}});
  table.add({"insert_distance_m",
             &o.insert_distance_m,
             "m",
             "translation after which a scan is inserted into the map, without loop closing; 0.4 as in the paper",
             0,
             10,
             {}});
  table.add({"insert_angle_rad",
             &o.insert_angle_rad,
             "rad",
             "rotation after which a scan is inserted into the map, without loop closing; 0.9 as in the paper",
             0,
             3.2,
             {}});
}

void add_match_options(OptionTable& table, HectorOptions& o) {
  table.add({"match_iterations", &o.match_iterations, "", "Gauss-Newton iterations per level, at most", 1, 100, {}});
  table.add({"min_score",
             &o.min_score,
             "",
             "minimum mean occupancy (0..1) of the map at the returns; below, the match is rejected and the pose is "
             "the guess",
             0,
             1,
             {}});
  table.add({"odometry_sigma_share",
             &o.odometry_sigma_share,
             "",
             "standard deviation of the odometry per distance; it only matters where the scan is degenerate, and in "
             "covariances "
             "until scans have shown how far odometry is off",
             0.001,
             10,
             {}});
  table.add({"odometry_yaw_sigma_share",
             &o.odometry_yaw_sigma_share,
             "",
             "standard deviation of the odometry per rotation",
             0.001,
             10,
             {}});
  table.add({"max_speed_m_per_s", &o.max_speed_m_per_s, "m/s", "odometry faster than this is rejected", 0.1, 1000, {}});
  table.add({"search_from_m",
             &o.search_from_m,
             "m",
             "a guess with a larger standard deviation is searched in a window, since the gradient of the map "
             "converges from a few cells only",
             0.01,
             100,
             {}});
  table.add({"search_from_rad", &o.search_from_rad, "rad", "the same for the rotation", 0.01, 10, {}});
  table.add({"search_reach_m", &o.search_reach_m, "m", "half of that window, at most", 0.05, 10, {}});
  table.add(
      {"search_reach_rad", &o.search_reach_rad, "rad", "half of that window in rotation, at most", 0.01, 3.2, {}});
  table.add(
      {"degenerate_ratio",
       &o.degenerate_ratio,
       "",
       "minimum ratio of surfaces across the motion to those along it; below, the scan is degenerate in one direction",
       0,
       1,
       {}});
  table.add_former_name("odometry_turn_sigma_share", "odometry_yaw_sigma_share");
}

void add_loop_options(OptionTable& table, HectorOptions& o) {
  table.add({"submap_scans", &o.submap_scans, "", "number of scans of a submap", 2, 10000, {}});
  table.add({"submap_insert_distance_m",
             &o.submap_insert_distance_m,
             "m",
             "as insert_distance_m, for submaps: smaller, as errors in submaps are corrected by loop closing",
             0,
             10,
             {}});
  table.add(
      {"submap_insert_angle_rad", &o.submap_insert_angle_rad, "rad", "as insert_angle_rad, for submaps", 0, 3.2, {}});
  table.add({"loop_scans",
             &o.loop_scans,
             "",
             "scans matched together in a loop search: a single one matches many places",
             1,
             100,
             {}});
  table.add({"loop_min_score",
             &o.loop_min_score,
             "",
             "minimum mean occupancy (0..1) of an old submap at the returns for a loop closure, and of the map "
             "where a scan fits badly at first or the one before was lost",
             0,
             1,
             {}});
  table.add({"loop_reach_m", &o.loop_reach_m, "m", "half of the loop search window without drift", 0.05, 100, {}});
  table.add({"loop_reach_rad", &o.loop_reach_rad, "rad", "the same for the rotation", 0.01, 3.2, {}});
  table.add({"loop_drift_share",
             &o.loop_drift_share,
             "",
             "growth of that window per distance since the last loop closure",
             0,
             1,
             {}});
  table.add({"loop_drift_rad_per_m", &o.loop_drift_rad_per_m, "rad/m", "the same for the rotation", 0, 1, {}});
  table.add({"loop_max_reach_m", &o.loop_max_reach_m, "m", "half of the loop search window, at most", 0.05, 100, {}});
  table.add({"loop_max_reach_rad", &o.loop_max_reach_rad, "rad", "the same for the rotation", 0.01, 3.2, {}});
}

void add_loop_choice_options(OptionTable& table, HectorOptions& o) {
  table.add({"loop_near_m", &o.loop_near_m, "m", "submaps farther away are not searched for loops", 0.1, 100, {}});
  table.add(
      {"loop_every", &o.loop_every, "", "key scans between two searches in a submap with a loop closure", 1, 1000, {}});
  table.add({"constrain_every",
             &o.constrain_every,
             "",
             "at the end, every n-th key scan is matched with all submaps near it",
             1,
             1000,
             {}});
  table.add({"optimize_every", &o.optimize_every, "", "key scans between two loop searches", 1, 10000, {}});
  table.add({"loop_sigma_m",
             &o.loop_sigma_m,
             "m",
             "standard deviation of a loop closure, added to that of the match",
             0.001,
             10,
             {}});
  table.add({"loop_sigma_rad", &o.loop_sigma_rad, "rad", "the same for the rotation", 0.0001, 1, {}});
  table.add({"loop_agreement_m",
             &o.loop_agreement_m,
             "m",
             "a loop closure that moves the map by more needs a second one that agrees with it to this",
             0.01,
             100,
             {}});
  table.add({"loop_agreement_rad", &o.loop_agreement_rad, "rad", "the same for the rotation", 0.001, 3.2, {}});
  table.add({"loop_reject_sigmas",
             &o.loop_reject_sigmas,
             "sigma",
             "loop closures with a larger residual are removed",
             1,
             1000,
             {}});
  table.add({"robust_width", &o.robust_width, "sigma", "width of the robust kernel of loop closures", 0.1, 1000, {}});
  table.add_former_name("tie_every", "constrain_every");
}

}  // namespace

OptionTable option_table(HectorOptions& options) {
  OptionTable table;
  add_method_options(table, options);
  add_scan_options(table, options);
  add_map_options(table, options);
  add_match_options(table, options);
  add_loop_options(table, options);
  add_loop_choice_options(table, options);
  return table;
}

}  // namespace rastro
