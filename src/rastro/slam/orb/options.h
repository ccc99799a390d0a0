// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "rastro/base/options.h"
#include "rastro/odometry/frame_check.h"

namespace rastro {

/// Settings of keyframe SLAM; meaning, range and reason of each are documented once, in option_table().
struct OrbSlamOptions {
  std::string sensor = "auto";

  // Features.
  int features = 0;
  int levels = 8;
  double scale_factor = 1.2;
  int fast_threshold = 20;
  int least_fast_threshold = 7;
  double pixel_sigma = 1.0;
  double more_features = 1.5;
  int few_tracked = 200;
  int enough_tracked = 400;

  // Depth.
  double virtual_baseline_m = 0.4;
  double depth_edge_sigmas = 2.5;
  double far_baselines = 40.0;
  int start_depth_points = 200;
  int stereo_hamming = 75;
  double stereo_disparity_share = 0.3;
  double stereo_least_disparity_px = 0.3;
  double stereo_difference_ratio = 2.0;

  // Initialization.
  double init_window_share = 0.16;
  int init_hamming = 64;
  double init_ratio = 0.8;
  int init_matches = 100;
  int init_points = 50;
  double init_parallax_deg = 1.0;
  double init_homography_share = 0.45;
  int init_iterations = 200;
  int init_frames = 60;
  int init_trial_frames = 30;
  double init_max_error = 1.5;

  // Tracking.
  std::string frontend = "orb";
  int tracks = 300;
  double tracks_distance_px = 15.0;
  double tracks_near_px = 2.0;
  int tracks_kept = 20000;
  double search_px = 12.0;
  double local_search_px = 4.0;
  int match_hamming = 80;
  double match_ratio = 0.9;
  double max_view_angle_deg = 60.0;
  int min_guess_inliers = 20;
  int min_inliers = 30;
  int localization_inliers = 20;
  double localization_distance_error = 0.05;
  double min_chance_ratio = 3.0;
  int weak_inliers = 150;
  double weak_share = 0.75;
  int established_inliers = 50;
  double established_share = 0.8;
  double established_contradiction = 50.0;
  double max_acceleration = 15.0;
  int pnp_iterations = 200;
  int local_keyframes = 40;
  int local_landmarks = 6000;

  // Keyframes.
  int keyframe_frames = 20;
  double keyframe_share = 0.9;
  double keyframe_share_depth = 0.75;
  int keyframe_few_points = 150;
  int keyframe_new_points = 70;
  int backend_delay_frames = 2;
  double backend_delay_s = 0.18;

  // Mapping.
  double cull_found_share = 0.25;
  int cull_keyframes = 3;
  int triangulate_neighbors = 12;
  int triangulate_hamming = 50;
  double triangulate_parallax_deg = 1.0;
  double epipolar_chi2 = 3.84;
  double fuse_px = 3.0;
  int adjust_keyframes = 20;
  int adjust_fixed = 20;
  int adjust_iterations = 10;
  double cull_seen_share = 0.9;
  int final_iterations = 10;
  int final_keyframes = 200;

  // Loop closing, relocalization.
  bool loop_closing = true;
  int covisible_landmarks = 15;
  int essential_landmarks = 100;
  int lost_frames = 30;
  int settled_frames = 20;
  double place_shared_words = 0.8;
  int place_candidates = 5;
  int place_hamming = 60;
  double place_ratio = 0.8;
  int relocalize_matches = 15;
  double relocalize_search_px = 10.0;
  int relocalize_frames = 3;
  double relocalize_chance_ratio = 4.2;
  double relocalize_visible_share = 0.08;
  int loop_neighbor_landmarks = 30;
  int loop_consistent = 3;
  int loop_inliers = 20;
  int loop_landmarks = 40;
  double loop_search_px = 8.0;
  double loop_chance_ratio = 11.0;
  double adjusted_rotation_share = 0.62;
  double position_drift_factor = 1.7;
  double scale_drift_share = 0.002;
  double loop_fit_share = 0.75;
  double loop_drift_share = 0.1;
  double loop_drift_rad_per_m = 0.02;
  double loop_max_sigmas = 5.0;
  int loop_min_gap = 10;
  int loop_adjust_iterations = 4;
  double loop_adjust_delay_s = 2.0;
  std::uint64_t seed = 1;

  FrameCheckOptions frame_check;
};

/// The table points into `options`, which must outlive it.
OptionTable option_table(OrbSlamOptions& options);

}  // namespace rastro
