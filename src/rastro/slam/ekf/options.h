// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/base/options.h"

namespace rastro {

/// Settings of EKF-SLAM. The defaults are the paper's where it gives a value (METHODS 3). Meaning, range and reason of
/// each are documented once, in option_table().
struct EkfOptions {
  // Odometry.
  double odometry_error_m_per_m = 0.02;
  double odometry_error_deg_per_45_deg = 2.0;
  double heading_error_deg_per_m = 0.5;
  double translation_scale_error = 0.02;
  double rotation_scale_error = 0.04;
  double max_speed_m_per_s = 5.0;
  double max_yaw_rate_deg_per_s = 360.0;
  double jump_m = 0.5;
  double jump_deg = 30.0;
  double unknown_speed_m_per_s = 0.5;
  double unknown_yaw_rate_deg_per_s = 30.0;
  double max_blind_m = 1.0;

  // Given landmarks.
  double range_noise_m = 0.05;
  double range_noise_share = 0.01;
  double bearing_noise_deg = 1.0;
  double max_observation_m = 200.0;

  // LandmarkAssociation.
  double gate = 9.21;
  double named_gate = 27.6;
  double new_gate = 27.6;
  double ambiguity = 3.0;
  double unsure_m = 0.5;
  int companions = 3;
  double max_direction_deg = 30.0;
  int observations = 5;
  int candidate_frames = 30;
  int max_landmarks = 1000;

  // Lines of a scan.
  std::uint64_t seed = 1;
  int min_returns = 20;
  double beam_noise_m = 0.02;
  double max_beam_m = 25.0;
  double beam_gap_m = 0.3;
  double beam_gap_share = 0.1;
  int ransac_iterations = 40;
  double ransac_reach_deg = 12.0;
  double line_tolerance_m = 0.06;
  int min_line_beams = 8;
  double min_line_m = 0.4;

  // Corners and spikes.
  bool corners = true;
  double min_corner_deg = 35.0;
  double corner_gap_m = 0.1;
  double corner_error_m = 0.02;
  bool spikes = true;
  int min_spike_beams = 2;
  int max_spike_beams = 8;
  double max_spike_m = 0.3;
  double spike_depth_m = 0.5;
  double max_spike_range_m = 5.0;
  double spike_error_m = 0.03;

  // Keyframes and grid.
  double keyframe_m = 1.0;
  double keyframe_deg = 30.0;
  bool grid = true;
  double cell_m = 0.05;
};

/// The table points into `options`, which must outlive it.
OptionTable option_table(EkfOptions& options);

}  // namespace rastro
