// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/map/images/image_layer.h"

namespace rastro {

/// The undistorted ray (x/z, y/z) of every pixel of an image.
class RayTable {
 public:
  RayTable() = default;
  RayTable(const Camera& camera, int width, int height);
  int width() const { return width_; }
  int height() const { return height_; }
  /// Not finite where the distortion cannot be inverted.
  const Eigen::Vector2f& at(int x, int y) const {
    return rays_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
  }

 private:
  int width_ = 0, height_ = 0;
  std::vector<Eigen::Vector2f> rays_;
};

/// Which pixels of a depth image are used, and their noise.
struct SurfaceOptions {
  int stride = 2;  ///< Every stride-th pixel of every stride-th row, >= 1.
  double min_depth_m = 0.3, max_depth_m = 5.0;
  double depth_sigma_m = 0.001, depth_sigma_per_m2 = 0.002;  ///< sigma(z) = depth_sigma_m + depth_sigma_per_m2 z^2.
  double grazing_deg = 80.0;  ///< Between ray and normal; surfaces at a more grazing angle are left out.
};

/// A measurement of a surface.
struct SurfaceSample {
  Eigen::Vector3f point_in_camera = Eigen::Vector3f::Zero();   ///< Meters.
  Eigen::Vector3f normal_in_camera = Eigen::Vector3f::Zero();  ///< Unit length, toward the camera; zero: unknown.
  float sigma = 0.0F;                                          ///< Of the depth, meters.
  std::array<std::uint8_t, 3> color{};                         ///< Red, green, blue.
};

/// The pixels that show a surface, row by row, without depth edges (their pixels mix two surfaces) and grazing angles.
/// Normals are those of planes through blocks of pixels, to reduce noise. `rays` has the images' size.
std::vector<SurfaceSample> surface_samples(const UnpackedImages& images, const RayTable& rays,
                                           const SurfaceOptions& options);

}  // namespace rastro
