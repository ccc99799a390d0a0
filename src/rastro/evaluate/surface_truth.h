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

enum class Visibility { visible, hidden_by_surface, outside_image };

struct Sighting {
  Visibility visibility = Visibility::outside_image;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< Where the point projects; meaningless when outside_image.
};

/// What scoring needs to know of a generated sequence: which surface point a pixel shows, and where (and whether) a
/// point is seen.
class SurfaceTruth {
 public:
  virtual ~SurfaceTruth() = default;
  virtual std::int64_t frame_count() const = 0;
  /// nullopt outside the image or where the ray meets nothing.
  virtual std::optional<SurfacePoint> surface_at(std::int64_t frame, const Eigen::Vector2d& pixel) const = 0;
  virtual Sighting sighting_of(std::int64_t frame, const SurfacePoint& point) const = 0;
};

}  // namespace rastro
