// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "rastro/base/options.h"
#include "rastro/odometry/frame_check.h"

namespace rastro {

/// Settings of direct semi-dense SLAM; meaning, range and reason of each are documented once, in option_table().
struct LsdOptions {
  std::uint64_t seed = 1;

  // Sensor.
  std::string sensor = "auto";
  double stereo_min_disparity_px = 1.0;
  double stereo_max_disparity_px = 100.0;
  double depth_sigma_m = 0.001;
  double depth_sigma_per_m2 = 0.005;
  double depth_edge_sigmas = 1.6;
  double min_depth_m = 0.3;
  double max_depth_m = 10.0;
  int start_pixels = 1000;

  // Start.
  std::string start = "two_views";
  double init_parallax_deg = 1.0;

  // Tracking.
  int levels = 5;
  int max_points = 8000;
  double min_overlap = 0.4;
  int lost_frames = 30;

  // What a pose is believed by.
  double trusted_alike = 0.5;
  double max_acceleration = 15.0;
  double trusted_regions = 0.75;
  double trusted_sigma = 0.03;
  double max_gain = 5.0;
  double max_jump_deg = 3.0;
  int relocalize_frames = 3;
  double max_drift = 0.1;
  double max_scale_error = 0.1;
  double scale_drift_share = 0.005;

  // Depth.
  double min_gradient = 8.0;
  double intensity_sigma = 3.0;
  double line_sigma_px = 0.4;
  double disparity_sigma_px = 0.5;
  double min_line_px = 3.0;
  double variance_growth = 1.01;
  double common_share = 0.7;
  double surface_share = 1.0;
  double max_depth_sigma = 0.1;
  double map_share = 0.2;

  // Keyframes.
  double keyframe_distance = 0.25;
  double keyframe_overlap = 0.85;
  double keyframe_residual = 5.0;
  double max_motion_error = 0.3;
  double max_keyframe_scale_error = 0.3;
  int keyframe_frames = 2;
  int earlier_frames = 2;
  double return_share = 0.75;
  int backend_delay_frames = 2;
  int backend_direct_frames = 2;

  // Constraints.
  int near_keyframes = 6;
  int similar_keyframes = 3;
  double max_reciprocal_error = 30.0;
  double min_constraint_overlap = 0.4;
  double loop_share = 0.85;
  int optimize_iterations = 20;

  // At the end.
  int refine_iterations = 30;
  int refine_points = 800;
  int refine_targets = 5;

  FrameCheckOptions frame_check;
};

/// The values of the papers, where they differ from rastro's own.
void set_paper_preset(LsdOptions& options);

/// The table points into `options`, which must outlive it.
OptionTable option_table(LsdOptions& options);

}  // namespace rastro
