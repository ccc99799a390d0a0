// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "rastro/base/options.h"

namespace rastro {

/// Settings of the occlusion-robust tracker; the defaults are the paper's (METHODS 1).
/// Names and reasons stand once, in option_table().
struct TrackOptions {
  std::string mode = "priority";  ///< klt, vote, dual, priority
  int features = 150;
  double min_distance_px = 30.0;
  int window = 30;
  std::string validation = "homography";  ///< homography, epipolar, local
  std::uint64_t seed = 1;
  // The rest is added by the tracker as it needs it.
};

/// The table points into `options`.
OptionTable option_table(TrackOptions& options);

}  // namespace rastro
