// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>
#include <vector>

#include "rastro/camera/camera.h"

namespace rastro {

/// Lens models that a calibration can estimate, simplest first.
enum class LensModel {
  pinhole_4,    ///< fx fy cx cy k1 k2 p1 p2: Brown 1966.
  pinhole_5,    ///< The same with k3.
  equidistant,  ///< fx fy cx cy k1 k2 k3 k4: Kannala and Brandt 2006.
  pinhole_8,    ///< fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6: OpenCV's rational polynomial.
};

/// "pinhole4", "pinhole5", "equidistant", "pinhole8".
std::string_view lens_model_name(LensModel model);
/// Of the parameters, in their order.
const std::vector<std::string_view>& lens_parameter_names(LensModel model);

/// A lens as a vector of parameters.
struct Lens {
  LensModel model = LensModel::pinhole_4;
  Eigen::VectorXd parameters;  ///< As many as lens_parameter_names(); focal lengths and center in pixels.

  /// Pixel of a point in the camera frame, with its derivatives by the point (2x3) and by the parameters (2xn);
  /// nullopt for z <= 0.
  struct Projection {
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> by_point;
    Eigen::Matrix2Xd by_parameters;
  };
  std::optional<Projection> project(const Eigen::Vector3d& point_in_camera) const;
  /// Unit ray of a pixel; nullopt where the distortion cannot be inverted.
  std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& pixel) const;
};

/// Without distortion.
Lens undistorted_lens(LensModel model, double focal_length, const Eigen::Vector2d& center);
/// The lens with the parameters that both models have, further ones 0. Between pinhole models only; between them and
/// the equidistant one the distortion begins at 0.
Lens as_model(const Lens& lens, LensModel model);
Camera camera_of(const Lens& lens, int width, int height);

}  // namespace rastro
