// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "rastro/camera/camera.h"

namespace rastro {

/// Converts between pixels and the pixels of an undistorted camera with the same focal length and principal point. In
/// the latter, planes and camera rotations move the image by homographies. Without a calibration both are the same.
class UndistortedCamera {
 public:
  explicit UndistortedCamera(std::optional<Camera> camera) : camera_(camera) {}

  bool is_identity() const { return !camera_ || camera_->distortion == Distortion::none; }
  /// The pixel itself where the distortion cannot be inverted.
  Eigen::Vector2f from_pixel(const Eigen::Vector2f& pixel) const;
  /// nullopt where the lens does not image the ray.
  std::optional<Eigen::Vector2d> to_pixel(const Eigen::Vector2d& ideal) const;
  /// Undistorted normalized ray; NaN without a calibration or where the distortion cannot be inverted.
  Eigen::Vector2f ray_of(const Eigen::Vector2f& pixel) const;

 private:
  std::optional<Camera> camera_;
};

}  // namespace rastro
