// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/map/images/image_layer.h"

namespace rastro {

/// The undistorted ray (x/z, y/z) of every pixel of a picture.
class RayTable {
 public:
  RayTable() = default;
  RayTable(const Camera& camera, int width, int height);
  int width() const { return width_; }
  int height() const { return height_; }
  /// Not finite where the distortion cannot be undone.
  const Eigen::Vector2f& at(int x, int y) const {
    return rays_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
  }

 private:
  int width_ = 0, height_ = 0;
  std::vector<Eigen::Vector2f> rays_;
};

/// Which pixels of a depth picture count, and how well they are known.
struct SurfaceOptions {
  int stride = 2;  ///< Every so many-th pixel of every so many-th row, >= 1.
  double min_depth_m = 0.3, max_depth_m = 5.0;
  double depth_sigma_m = 0.001, depth_sigma_per_m2 = 0.002;  ///< sigma(z) = depth_sigma_m + depth_sigma_per_m2 z^2.
  double grazing_deg = 80.0;  ///< Between ray and normal; what is seen flatter is left out.
};

/// A measurement of a surface.
struct SurfaceSample {
  Eigen::Vector3f point_in_camera = Eigen::Vector3f::Zero();   ///< Metres.
  Eigen::Vector3f normal_in_camera = Eigen::Vector3f::Zero();  ///< Unit length, towards the camera; zero: not known.
  float sigma = 0.0F;                                          ///< Of the depth, metres.
  std::array<std::uint8_t, 3> colour{};                        ///< Red, green, blue.
};

/// The pixels that show a surface, row by row: no edges of depth (their pixels mix two surfaces), nothing seen at a
/// grazing angle. Normals are those of planes through blocks of pixels, so that noise weighs little. `rays` is of the
/// pictures' size.
std::vector<SurfaceSample> surface_samples(const UnpackedPictures& pictures, const RayTable& rays,
                                           const SurfaceOptions& options);

}  // namespace rastro
