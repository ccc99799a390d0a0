// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/options.h"

namespace rastro {
namespace {

void add_method_options(OptionTable& table, HectorOptions& o) {
  table.add({"guess",
             &o.guess,
             "",
             "where the next scan is expected: from wheel odometry (from the speed so far where there is none), from "
             "the speed so far, or where the last scan was (the paper's way)",
             0,
             0,
             {"odometry", "constant-velocity", "none"}});
  table.add({"loop_closing",
             &o.loop_closing,
             "",
             "find places again and correct the map: what scan matching alone lacks; false: one map, the paper's way",
             0,
             1,
             {}});
}

void add_scan_options(OptionTable& table, HectorOptions& o) {
  table.add({"min_range_m", &o.min_range_m, "m", "nearer returns are left out, as of the robot itself", 0, 100, {}});
  table.add({"max_range_m",
             &o.max_range_m,
             "m",
             "farther returns are left out; few scanners measure well beyond 30 m",
             0.1,
             1000,
             {}});
  table.add({"min_returns", &o.min_returns, "", "beams with a return that a pose needs", 3, 10000, {}});
}

void add_map_options(OptionTable& table, HectorOptions& o) {
  table.add({"cell_m", &o.cell_m, "m", "side of the finest cells", 0.005, 1, {}});
  table.add({"levels", &o.levels, "", "resolutions, each half as fine as the one before; 3 as in the paper", 1, 6, {}});
  table.add({"occupied_probability",
             &o.occupied_probability,
             "",
             "of a cell with a return, from one scan; 0.9 as in the paper",
             0.51,
             0.99,
             {}});
  table.add({"free_probability",
             &o.free_probability,
             "",
             "of a cell a beam went through, from one scan; 0.4 as in the paper",
             0.01,
             0.49,
             {}});
  table.add({"insert_distance_m",
             &o.insert_distance_m,
             "m",
             "way after which a scan goes into the map where no loops are closed; 0.4 as in the paper",
             0,
             10,
             {}});
  table.add({"insert_angle_rad",
             &o.insert_angle_rad,
             "rad",
             "turn after which a scan goes into the map where no loops are closed; 0.9 as in the paper",
             0,
             3.2,
             {}});
}

void add_match_options(OptionTable& table, HectorOptions& o) {
  table.add({"match_iterations", &o.match_iterations, "", "Gauss-Newton steps on each level at most", 1, 100, {}});
  table.add({"min_score",
             &o.min_score,
             "",
             "mean of the map (0..1) at the returns; below, the scan does not fit and the guess stands",
             0,
             1,
             {}});
  table.add({"odometry_sigma_share",
             &o.odometry_sigma_share,
             "",
             "sigma of odometry by way; it only decides where the scan does not",
             0.001,
             10,
             {}});
  table.add(
      {"odometry_turn_sigma_share", &o.odometry_turn_sigma_share, "", "sigma of odometry by turn", 0.001, 10, {}});
  table.add(
      {"max_speed_m_per_s", &o.max_speed_m_per_s, "m/s", "odometry that is faster is not believed", 0.1, 1000, {}});
  table.add({"search_from_m",
             &o.search_from_m,
             "m",
             "a guess less sure than this is looked for in a window, as the slope of the map leads only some cells far",
             0.01,
             100,
             {}});
  table.add({"search_from_rad", &o.search_from_rad, "rad", "the same for the turn", 0.01, 10, {}});
  table.add({"search_reach_m", &o.search_reach_m, "m", "half of that window at most", 0.05, 10, {}});
  table.add({"search_reach_rad", &o.search_reach_rad, "rad", "half of that window's turn", 0.01, 3.2, {}});
  table.add({"degenerate_ratio",
             &o.degenerate_ratio,
             "",
             "share of surfaces across the way to those along it; below, the scan says nothing along one direction",
             0,
             1,
             {}});
}

void add_loop_options(OptionTable& table, HectorOptions& o) {
  table.add({"submap_scans", &o.submap_scans, "", "scans that make a submap", 2, 10000, {}});
  table.add({"submap_insert_distance_m",
             &o.submap_insert_distance_m,
             "m",
             "as insert_distance_m, into submaps: small ones bear more, as their errors can be mended",
             0,
             10,
             {}});
  table.add(
      {"submap_insert_angle_rad", &o.submap_insert_angle_rad, "rad", "as insert_angle_rad, into submaps", 0, 3.2, {}});
  table.add({"loop_scans", &o.loop_scans, "", "scans looked for together: one alone fits in many places", 1, 100, {}});
  table.add({"loop_min_score",
             &o.loop_min_score,
             "",
             "mean of an old submap at the returns (0..1) from which a place is found again",
             0,
             1,
             {}});
  table.add(
      {"loop_reach_m", &o.loop_reach_m, "m", "half of the window looked through without any drift", 0.05, 100, {}});
  table.add({"loop_reach_rad", &o.loop_reach_rad, "rad", "the same for the turn", 0.01, 3.2, {}});
  table.add(
      {"loop_drift_share", &o.loop_drift_share, "", "growth of that window by way since the last loop", 0, 1, {}});
  table.add({"loop_drift_rad_per_m", &o.loop_drift_rad_per_m, "rad/m", "the same for the turn", 0, 1, {}});
  table.add({"loop_max_reach_m", &o.loop_max_reach_m, "m", "the window grows no larger", 0.05, 100, {}});
  table.add({"loop_max_reach_rad", &o.loop_max_reach_rad, "rad", "the same for the turn", 0.01, 3.2, {}});
}

void add_loop_choice_options(OptionTable& table, HectorOptions& o) {
  table.add({"loop_near_m", &o.loop_near_m, "m", "submaps that come no nearer are not looked at", 0.1, 100, {}});
  table.add(
      {"loop_every", &o.loop_every, "", "key scans between two looks at a submap that has been found", 1, 1000, {}});
  table.add(
      {"tie_every", &o.tie_every, "", "at the end, each n-th key scan is tied to all submaps near it", 1, 1000, {}});
  table.add({"optimize_every", &o.optimize_every, "", "key scans between two searches for loops", 1, 10000, {}});
  table.add(
      {"loop_sigma_m", &o.loop_sigma_m, "m", "of a place found again, beside what the match says", 0.001, 10, {}});
  table.add({"loop_sigma_rad", &o.loop_sigma_rad, "rad", "the same for the turn", 0.0001, 1, {}});
  table.add({"loop_agreement_m",
             &o.loop_agreement_m,
             "m",
             "a loop that moves the map by more needs a second that moves it the same way to this",
             0.01,
             100,
             {}});
  table.add({"loop_agreement_rad", &o.loop_agreement_rad, "rad", "the same for the turn", 0.001, 3.2, {}});
  table.add({"loop_reject_sigmas",
             &o.loop_reject_sigmas,
             "sigma",
             "loops that disagree with all else by more are taken out",
             1,
             1000,
             {}});
  table.add({"robust_width", &o.robust_width, "sigma", "loops that disagree by more lose their pull", 0.1, 1000, {}});
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
