// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/odometry/rgbd_tracking/feature_tracker.h"

namespace rastro {

/// How much each observation counts for how much of the image, 1 to 1000: those of one part of the image share its
/// weight. Something textured that moves before a plain wall has most of the features, but not most of the image.
std::vector<std::int32_t> coverage_weights(std::span<const FoundPoint> found, const Camera& camera);

/// 0..1: share of the weights of those that are set in `chosen`, one per weight; 0 without weights.
double weighted_share(std::span<const std::int32_t> weights, std::span<const std::uint8_t> chosen);

/// Parts of an image, chosen or not.
struct ImageParts {
  static constexpr int part_px = 32;
  int columns = 0, rows = 0;
  std::vector<std::uint8_t> chosen;  ///< Row by row.

  bool any() const {
    return std::any_of(chosen.begin(), chosen.end(), [](std::uint8_t each) { return each != 0; });
  }
  bool at(int x_px, int y_px) const {
    const int x = x_px / part_px, y = y_px / part_px;
    return x < columns && y < rows && chosen[static_cast<std::size_t>(y * columns + x)] != 0;
  }
};

/// Parts of the image in which most features do not fit the motion of the rest, and those beside them: something moves
/// there. `fits`: one per feature.
ImageParts moving_parts(std::span<const FoundPoint> found, std::span<const std::uint8_t> fits, const Camera& camera);

}  // namespace rastro
