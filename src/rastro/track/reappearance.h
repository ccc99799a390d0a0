// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "rastro/track/motion_history.h"
#include "rastro/track/options.h"

namespace rastro {

/// A lost feature that has reappeared.
struct Reappeared {
  std::size_t track = 0;
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
  float residual_ratio = 0.0F;
};

/// The descriptor of a position, for surroundings rotated and scaled by this much since the descriptor to compare with.
using DescribeRotated = std::function<Descriptor(const Eigen::Vector2f& pixel, double angle_rad, double scale)>;

/// Whether a feature may reappear at a position.
using HasRoom = std::function<bool(const Eigen::Vector2f& pixel)>;

/// Guided search for each lost feature: at the position, rotation and scale that the motion of the tracked features
/// since its last observation predicts. No corner needs to be detected there. Beyond METHODS 1, whose corners alone
/// miss what the detector does not repeat and what has rotated or grown while occluded. Most similar first.
std::vector<Reappeared> find_reappeared(std::span<const Association> followed, const TrackStore& store,
                                        std::int64_t current, MotionHistory& history, const UndistortedCamera& camera,
                                        const Pyramid& image, const HasRoom& has_room, const DescribeRotated& describe,
                                        const TrackOptions& options);

}  // namespace rastro
