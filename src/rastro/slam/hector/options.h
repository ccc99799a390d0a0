// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/base/options.h"

namespace rastro {

/// Settings of the scan matcher; meaning, range and reason of each are documented once, in option_table().
struct HectorOptions {
  std::string guess = "odometry";
  bool loop_closing = true;

  // Scans.
  double min_range_m = 0.05;
  double max_range_m = 30.0;
  int min_returns = 20;

  // Map.
  double cell_m = 0.05;
  int levels = 3;
  double occupied_probability = 0.9;
  double free_probability = 0.4;
  double insert_distance_m = 0.4;
  double insert_angle_rad = 0.9;

  // Matching.
  int match_iterations = 8;
  double min_score = 0.4;
  double odometry_sigma_share = 0.1;
  double odometry_yaw_sigma_share = 0.2;
  double max_speed_m_per_s = 10.0;
  double search_from_m = 0.15;
  double search_from_rad = 0.05;
  double search_reach_m = 0.4;
  double search_reach_rad = 0.5;
  double degenerate_ratio = 0.02;

  // Submaps and loops.
  int submap_scans = 40;
  double submap_insert_distance_m = 0.2;
  double submap_insert_angle_rad = 0.3;
  int loop_scans = 5;
  double loop_min_score = 0.6;
  double loop_reach_m = 0.4;
  double loop_reach_rad = 0.15;
  double loop_drift_share = 0.03;
  double loop_drift_rad_per_m = 0.005;
  double loop_max_reach_m = 6.0;
  double loop_max_reach_rad = 0.6;
  double loop_near_m = 4.0;
  int loop_every = 4;
  int constrain_every = 2;
  int optimize_every = 20;
  double loop_sigma_m = 0.03;
  double loop_sigma_rad = 0.01;
  double loop_agreement_m = 0.4;
  double loop_agreement_rad = 0.06;
  double loop_reject_sigmas = 8.0;
  double robust_width = 2.0;
};

/// The table points into `options`, which must outlive it.
OptionTable option_table(HectorOptions& options);

}  // namespace rastro
