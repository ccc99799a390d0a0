// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "rastro/track/motion_history.h"
#include "rastro/track/options.h"

namespace rastro {

/// A lost feature seen again.
struct Reappeared {
  std::size_t track = 0;
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
  float residual_ratio = 0.0F;
};

/// The descriptor of a place whose surroundings turned and grew by so much since the descriptor to compare with.
using DescribeTurned = std::function<Descriptor(const Eigen::Vector2f& pixel, double angle_rad, double scale)>;

/// Whether a feature may come back at a place.
using HasRoom = std::function<bool(const Eigen::Vector2f& pixel)>;

/// Looks for each lost feature where the motion of the followed ones since it was last seen puts it, turned and scaled
/// by that motion; no corner need be detected there. Beyond METHODS 1, whose corners alone miss what a detector does
/// not find again and what has turned or grown while hidden. The most alike come first.
std::vector<Reappeared> find_reappeared(std::span<const Association> followed, const TrackStore& store,
                                        std::int64_t current, MotionHistory& history, const IdealCamera& camera,
                                        const Pyramid& image, const HasRoom& has_room, const DescribeTurned& describe,
                                        const TrackOptions& options);

}  // namespace rastro
