// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/base/options.h"
#include "rastro/slam/orb/options.h"

namespace rastro {

/// Settings of fusion; meaning, range and reason of each are documented once, in option_table().
struct FusionOptions {
  OrbSlamOptions orb;  ///< Features, map and loops; its table is part of this one's, but for what one camera needs.

  // Sensor.
  std::string sensor = "auto";
  double depth_sigma_m = 0.001;
  double depth_sigma_per_m2 = 0.002;
  double min_depth_m = 0.3;
  double max_depth_m = 8.0;
  double stereo_sigma_px = 0.3;
  double stereo_min_disparity_px = 2.0;
  int stereo_max_disparity_px = 96;

  // Direct alignment.
  int direct_points = 6000;
  double intensity_sigma = 3.0;
  double surface_weight = 0.05;
  double most_disagreement = 4.0;
  double disagreement_share = 0.3;
  double trusted_alike = 0.5;
  double common_sigma_m = 0.0005;
  double common_sigma_rad = 0.0003;
};

/// The table points into `options`, which must outlive it.
OptionTable option_table(FusionOptions& options);

}  // namespace rastro
