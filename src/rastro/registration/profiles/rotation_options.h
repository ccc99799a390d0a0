// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/base/options.h"

namespace rastro {

/// Settings of rotation from intensity profiles, METHODS 2.2. add_options() gives meaning, range and reason of each.
struct RotationOptions {
  int max_shift_px = 150;
  double lambda = 0.0;  ///< rad/px; 0: 1 / fx.
  std::string profile = "gradient";
  int gradient_reach_px = 3;
  bool equal_angles = true;

  // Columns, for yaw.
  double band_top = 0.2;
  double band_bottom = 0.5;
  double max_expansion = 0.2;

  // Rows, for pitch.
  bool pitch = true;
  int max_pitch_shift_px = 40;
  double band_left = 0.35;
  double band_right = 0.65;
  double max_pitch_expansion = 0.4;
  double pitch_forgetting = 0.05;

  // Evaluation.
  double min_confidence = 0.1;
  double max_still_difference = 0.15;  ///< Share of the mean over all shifts.
  double max_rotation_change_deg = 4.0;
};

/// The paper's own profiles: plain sums of whole columns, no pitch.
void set_paper_preset(RotationOptions& options);

/// Adds the rows of `options` to a method's table; `options` must outlive it.
void add_options(OptionTable& table, RotationOptions& options);

}  // namespace rastro
