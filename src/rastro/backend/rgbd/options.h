// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "rastro/base/options.h"
#include "rastro/odometry/rgbd_tracking/options.h"

namespace rastro {

/// Settings of RGB-D SLAM; meaning, range and reason of each are documented once, in option_table(). The camera's noise
/// is set in `follow`.
struct RgbdSlamOptions {
  RgbdOptions follow;  ///< Of the odometry used for tracking; its table is part of this one's.

  // Keyframes.
  std::string descriptor = "orb";
  int keyframe_features = 600;
  double keyframe_distance_m = 0.15;
  double keyframe_angle_rad = 0.15;
  int keyframe_frames = 30;
  int dense_keyframes = 5;

  // Keyframe candidates.
  int last_candidates = 2;
  int near_candidates = 3;
  int graph_candidates = 2;
  int random_candidates = 2;
  int join_candidates = 3;
  double near_distance_m = 1.0;
  double near_angle_rad = 0.7;

  // Matching.
  double max_ratio = 0.85;
  double pixel_sigma = 1.0;
  int ransac_iterations = 300;
  int min_inliers = 25;
  int loop_inliers = 25;
  bool match_far = true;
  std::string few_features = "icp";
  int few_inliers = 10;
  double min_inlier_share = 0.25;
  double agreement = 0.9;
  double agreement_overlap = 0.1;
  double min_alike = 0.0;
  double edge_sigma_m = 0.003;
  double edge_sigma_rad = 0.0015;

  // Graph.
  std::string loops = "switchable";
  double switch_price = 30.0;
  double robust_width = 4.0;
  int graph_window = 15;
  int loop_steps = 12;
  double loop_drift_share = 0.1;
  double loop_drift_rad_per_m = 0.02;
  double loop_max_sigmas = 5.0;
  double tracked_drift_share = 0.02;
  double max_acceleration = 15.0;
  int optimize_iterations = 10;
  int backend_delay_frames = 10;

  // Lost.
  int relocalize_every = 2;
  int relocalize_last = 3;
  int relocalize_random = 3;
  int relocalize_inliers = 30;
  int relocalize_frames = 3;
  int lost_frames = 60;
  double lost_s = 2.0;

  double memory_reserve_mb = 250.0;
};

/// The table points into `options`, which must outlive it.
OptionTable option_table(RgbdSlamOptions& options);

}  // namespace rastro
