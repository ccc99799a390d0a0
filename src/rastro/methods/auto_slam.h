// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "rastro/slam/slam_method.h"

namespace rastro {

/// Settings of the choice.
struct AutoSlamOptions {
  double least_texture = 0.25;  ///< Share of the image with corners, below which surfaces are trusted more.
  int corner_threshold = 7;     ///< Gray levels; that of weak corners in keyframe SLAM.
  std::uint64_t seed = 1;       ///< Of the method in use, where it has random numbers.
  double patience_s = 2.0;      ///< So long a method may give no pose at the start before another one is tried.
};

using SlamMethodByName = std::function<std::unique_ptr<SlamMethod>(const std::string&)>;

/// Chooses a method by the sensors, the calibration and the texture of the first image, and says why in an event
/// "method".
/// Where the chosen one has no pose after `patience_s` and another suits the source too, that one takes over, from this
/// frame on; nothing was mapped until then. The map is one of the method in use. `method_by_name` must know the methods
/// of slam_choices().
std::unique_ptr<SlamMethod> auto_slam_method(SlamMethodByName method_by_name);

}  // namespace rastro
