// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "rastro/base/options.h"
#include "rastro/odometry/frame_check.h"

namespace rastro {

/// Settings of depth camera tracking, METHODS 8. option_table() gives meaning, range and reason of each.
struct RgbdOptions {
  // Depth.
  double depth_sigma_m = 0.001;
  double depth_sigma_per_m2 = 0.002;
  double depth_edge_sigmas = 4.0;
  double min_depth_m = 0.3;
  double max_depth_m = 6.0;
  bool learn_delay = true;
  double weak_sigma = 0.02;

  // Features.
  int features = 500;
  double min_distance_px = 12.0;
  int patch_px = 13;
  double pixel_sigma = 0.7;
  double shared_error_px = 1.0;
  double max_error_px = 3.0;
  int min_points = 12;
  int ransac_iterations = 200;
  std::uint64_t seed = 1;

  // Surfaces.
  std::string surfaces = "on";
  double surface_weight = 0.2;

  // Reference frames.
  double max_reference_rotation_deg = 12.0;
  double max_reference_motion_m = 0.1;
  double min_reference_share = 0.6;
  int map_references = 40;

  FrameCheckOptions frame_check;
};

/// The table points into `options`, which must outlive it.
OptionTable option_table(RgbdOptions& options);

}  // namespace rastro
