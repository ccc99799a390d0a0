// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/backend/rgbd/options.h"
#include "rastro/base/options.h"

namespace rastro {

/// Settings of appearance-based SLAM with memory management; meaning, range and reason of each are documented once, in
/// option_table(). Tracking, matching and the graph are set in `rgbd`.
struct RtabmapOptions {
  RtabmapOptions();

  RgbdSlamOptions rgbd;  ///< Its table is part of this one's, but for its own search for loops.

  // Sensor.
  std::string sensor = "auto";
  double stereo_sigma_px = 0.3;
  double stereo_min_disparity_px = 3.0;
  int stereo_max_disparity_px = 96;

  // Words.
  double distance_ratio = 0.8;
  int words_per_image = 300;
  double bad_signature = 0.25;

  // Memory.
  int short_term_size = 30;
  double rehearsal_similarity = 0.2;
  double time_limit_ms = 10.0;
  int retrieved_neighbors = 2;

  // Bayes filter.
  double loop_probability = 0.11;
  double stays_new = 0.9;
  double neighbor_sigma = 1.6;
  int hypotheses = 2;

  // Index of all locations.
  int similar_locations = 8;
  double least_similarity = 0.3;
};

/// The values of the papers, where they differ from rastro's own.
void set_paper_preset(RtabmapOptions& options);

/// The table points into `options`, which must outlive it.
OptionTable option_table(RtabmapOptions& options);

}  // namespace rastro
