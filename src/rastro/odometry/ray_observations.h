// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace rastro {

/// A feature in a frame: its id and its undistorted normalized ray.
struct RayObservation {
  std::int64_t id = 0;
  Eigen::Vector2d ray = Eigen::Vector2d::Zero();
};

/// RayObservations of one frame, in ascending order of id.
using RayObservations = std::vector<RayObservation>;

/// The ray of a feature in a frame; null where the frame does not have it.
const Eigen::Vector2d* find_ray(const RayObservations& observations, std::int64_t id);

/// Matches of two frames: rays of the same features.
struct SharedRays {
  std::vector<Eigen::Vector2d> a, b;
  std::vector<std::int64_t> ids;
};

SharedRays shared_rays(const RayObservations& first, const RayObservations& second);

/// Median distance of the rays of a match, in pixels of a camera of this focal length; 0 without matches.
double median_motion_px(const SharedRays& shared, double focal_px);

}  // namespace rastro
