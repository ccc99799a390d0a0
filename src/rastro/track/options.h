// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rastro/base/options.h"

namespace rastro {

/// Settings of the occlusion-robust tracker; the defaults are the paper's where it gives a value (METHODS 1).
/// option_table() gives meaning, range and reason of each.
struct TrackOptions {
  std::string mode = "priority";
  int features = 150;
  double min_distance_px = 30.0;
  int window = 30;
  std::uint64_t seed = 1;
  bool equalize = false;

  // Optical flow.
  int flow_window_px = 21;
  int flow_levels = 4;
  int flow_iterations = 30;
  double flow_epsilon_px = 0.03;
  double flow_coarse_epsilon_px = 0.03;
  double max_backward_px = 0.5;
  double max_residual_ratio = 0.1;
  double min_texture = 0.1;
  int reference_interval = 4;
  double max_reference_residual = 0.4;
  double max_epipolar_error_px = 0.7;

  // Corners.
  double corner_quality = 0.01;
  int corner_border_px = 5;
  bool verify_corners = true;
  double candidates_factor = 3.0;
  double max_candidates_factor = 3.0;
  double candidates_distance_px = 5.0;
  bool displace = false;

  // Descriptors and votes.
  int brief_patch_px = 48;
  int brief_smoothing_px = 9;
  std::string descriptor = "upright";
  int max_hamming = 50;
  int min_votes = 1;
  double max_travel_px = 60.0;

  // Guided search for lost features at their predicted positions.
  bool predict = true;

  // Alignment with the lost feature's patch.
  bool align = true;
  int patch_window_px = 21;
  double max_alignment_px = 5.0;
  double max_alignment_residual = 0.25;
  double min_alignment_texture = 0.5;

  // Validation.
  std::string validation = "homography";
  double max_reprojection_px = 2.5;
  int min_inliers = 8;
  double min_inlier_share = 0.75;
  int ransac_iterations = 80;
};

/// Names of sets of values beside the defaults: "paper".
std::vector<std::string> track_presets();
/// The paper's own steps and thresholds: what is beyond it is off. Leaves `mode`, `features`, `window` and `seed`.
void set_paper_preset(TrackOptions& options);

/// The table points into `options`, which must outlive it.
OptionTable option_table(TrackOptions& options);

}  // namespace rastro
