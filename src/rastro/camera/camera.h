// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace rastro {

enum class Distortion {
  none,
  radial_tangential,  ///< k1 k2 p1 p2 [k3]: Brown 1966, in the order of OpenCV.
  equidistant,        ///< k1 k2 k3 k4: Kannala and Brandt 2006.
  rational,           ///< k1 k2 p1 p2 k3 k4 k5 k6: radial part (1 + k1.. k3) / (1 + k4.. k6), in the order of OpenCV.
};

/// Pinhole camera with lens distortion. Camera frame: x right, y down, z forward; pixel centers are at integers.
struct Camera {
  int width = 0;  ///< Pixels; 0 if not in the calibration.
  int height = 0;
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  ///< Pixels.
  Distortion distortion = Distortion::none;
  std::array<double, 8> coefficients{};  ///< Those that the model does not have are 0.
  /// Of a rolling shutter: seconds from the first row to the last, the middle one at the frame's stamp. 0: all at once.
  double readout_s = 0.0;

  /// Pixel of a point in the camera frame; nullopt if it is not in front of the camera (z <= 0) or outside the model's
  /// range.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point_in_camera) const;
  /// Same, with the 2x3 derivative of the pixel by the point.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point_in_camera,
                                         Eigen::Matrix<double, 2, 3>& jacobian) const;
  /// Undistorted normalized ray (x/z, y/z) of a pixel; nullopt if the distortion cannot be inverted there.
  std::optional<Eigen::Vector2d> unproject(const Eigen::Vector2d& pixel) const;
  /// How many coefficients the model has: 0, 4 (radial-tangential with k3 = 0 too), 5 or 8.
  std::size_t coefficient_count() const;
  /// The same camera for an image scaled by `scale`.
  Camera scaled(double scale) const;
};

/// A pinhole camera without distortion, from a horizontal field of view in degrees: an approximation for uncalibrated
/// images.
Camera camera_from_field_of_view(double degrees, int width, int height);

/// Plausibility check of a calibration: one plain line per doubt, empty without any. Checks focal length against width,
/// fx against fy, principal point inside the image, distortion monotonic over the image
/// and not larger than that of a lens.
std::vector<std::string> calibration_warnings(const Camera& camera);

}  // namespace rastro
