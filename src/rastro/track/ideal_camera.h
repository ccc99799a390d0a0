// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "rastro/camera/camera.h"

namespace rastro {

/// Goes between pixels and those of a camera without distortion, of the same focal length and middle: there, planes and
/// turns of the camera move the image by homographies. Without a calibration both are the same.
class IdealCamera {
 public:
  explicit IdealCamera(std::optional<Camera> camera) : camera_(camera) {}

  bool is_identity() const { return !camera_ || camera_->distortion == Distortion::none; }
  /// The pixel itself where the distortion cannot be undone.
  Eigen::Vector2f from_pixel(const Eigen::Vector2f& pixel) const;
  /// nullopt where the lens images no such ray.
  std::optional<Eigen::Vector2d> to_pixel(const Eigen::Vector2d& ideal) const;
  /// Undistorted normalised ray; NaN without a calibration and where the distortion cannot be undone.
  Eigen::Vector2f ray_of(const Eigen::Vector2f& pixel) const;

 private:
  std::optional<Camera> camera_;
};

}  // namespace rastro
