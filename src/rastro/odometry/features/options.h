// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "rastro/base/options.h"

namespace rastro {

/// Settings of the odometry from features, METHODS 2.1. option_table() gives meaning, range and reason of each.
struct FeaturesOptions {
  std::string matcher = "tracks";
  int features = 400;
  double min_distance_px = 14.0;
  int max_keypoints = 1500;
  double max_ratio = 0.8;
  std::uint64_t seed = 1;

  // Initialization.
  double min_start_parallax_deg = 1.0;
  int min_start_points = 40;
  double min_start_inlier_share = 0.7;
  double min_motion_px = 0.3;

  // Tracking.
  double max_error_px = 2.0;
  int min_points = 12;
  int ransac_iterations = 200;

  // Keyframes and points.
  double keyframe_parallax_px = 8.0;
  double min_keyframe_share = 0.6;
  double min_point_parallax_deg = 0.5;
  double max_point_error_px = 2.0;

  // Refinement.
  bool refine = true;
  int window_keyframes = 8;
  int refine_iterations = 4;
  double huber_px = 1.0;
  double calibration_tolerance = 0.045;
};

/// The table points into `options`, which must outlive it.
OptionTable option_table(FeaturesOptions& options);

}  // namespace rastro
