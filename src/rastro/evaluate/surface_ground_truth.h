// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

namespace rastro {

/// A point on a surface of a generated world.
struct SurfacePoint {
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  std::uint32_t surface = 0;
};

enum class Visibility { visible, occluded_by_surface, outside_image };

struct ProjectedPoint {
  Visibility visibility = Visibility::outside_image;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< Projection of the point; undefined if outside_image.
};

/// Ground truth of a generated sequence for scoring: the surface point at a pixel, and the projection and
/// visibility of a point.
class SurfaceGroundTruth {
 public:
  virtual ~SurfaceGroundTruth() = default;
  virtual std::int64_t frame_count() const = 0;
  /// nullopt outside the image or if the ray hits nothing.
  virtual std::optional<SurfacePoint> surface_at(std::int64_t frame, const Eigen::Vector2d& pixel) const = 0;
  virtual ProjectedPoint project(std::int64_t frame, const SurfacePoint& point) const = 0;
};

}  // namespace rastro
