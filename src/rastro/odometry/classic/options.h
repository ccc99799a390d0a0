// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "rastro/base/options.h"
#include "rastro/odometry/frame_check.h"

namespace rastro {

/// Settings of the classic odometry, METHODS 2.1. option_table() gives meaning, range and reason of each.
struct ClassicOptions {
  // Features.
  std::string matcher = "surf";
  int max_keypoints = 1500;
  double surf_threshold = 30.0;
  double sift_contrast = 0.04;
  int orb_fast_threshold = 12;
  double max_ratio = 0.6;
  bool mutual = true;
  std::uint64_t seed = 1;

  // Two views.
  double max_epipolar_error_px = 1.0;
  double max_point_error_px = 2.0;
  double min_point_parallax_deg = 0.0;
  double min_parallax_deg = 0.1;
  double min_motion_px = 0.3;

  // The third.
  double max_error_px = 2.0;
  int refine_iterations = 10;

  // Both.
  int ransac_iterations = 500;
  double ransac_confidence = 0.99;
  int min_points = 12;
  double min_inlier_share = 0.3;
  int max_bridged_frames = 5;

  FrameCheckOptions check;
};

/// The paper has no test of a frame's usefulness (METHODS 2.6): every frame moves on.
void set_paper_preset(ClassicOptions& options);

/// The table points into `options`, which must outlive it.
OptionTable option_table(ClassicOptions& options);

}  // namespace rastro
