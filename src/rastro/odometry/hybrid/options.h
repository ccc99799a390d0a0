// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/base/options.h"
#include "rastro/odometry/frame_check.h"
#include "rastro/registration/profiles/rotation_options.h"

namespace rastro {

/// Settings of the hybrid odometry, METHODS 2.3. option_table() gives meaning, range and reason of each.
struct HybridOptions {
  int features = 400;
  double min_distance_px = 14.0;
  std::uint64_t seed = 1;

  // Initialization.
  double min_start_parallax_px = 5.0;
  double min_motion_px = 0.3;

  // Tracking.
  double min_parallax_px = 2.0;
  double max_error_px = 4.0;
  double max_point_error_px = 4.0;
  double min_point_parallax_deg = 0.2;
  int min_points = 12;
  double min_inlier_share = 0.3;
  int ransac_iterations = 200;
  double max_speed_ratio = 4.0;
  int max_bridged_frames = 5;

  RotationOptions rotation;
  FrameCheckOptions check;
};

/// The paper's own steps: plain profiles, no pitch, every frame moves on.
void set_paper_preset(HybridOptions& options);

/// The table points into `options`, which must outlive it.
OptionTable option_table(HybridOptions& options);

}  // namespace rastro
