// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/camera/depth_registration.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"

namespace rastro {

/// A board seen by the color camera and the depth camera at the same time.
struct DepthView {
  SE3 color_from_board;
  const DepthImage* depth = nullptr;  ///< Meters as the camera says, 0: none.
};

struct DepthCalibrationInput {
  /// Of the depth images. Depth that the device registered to the color image has the camera of the color image.
  Camera depth_camera;
  /// Whether the device registered depth to color: then a transform is estimated only to check it.
  bool registered = true;
  SE3 color_from_depth;       ///< To begin with: identity where registered, else as measured by hand.
  Eigen::Vector2d low, high;  ///< Where the board is flat and painted, in its own plane; meters.
  /// Standard deviation of the color camera's focal length as share of it: the distances of all boards have it in
  /// common.
  double focal_length_sigma = 0.0;
  std::vector<DepthView> views;
};

/// How depth is to be corrected: true depth = scale * depth + offset_m.
struct DepthCalibration {
  int views = 0;  ///< With enough depth on the board.
  int readings = 0;
  double scale = 1.0, scale_sigma = 0.0;
  double offset_m = 0.0, offset_sigma_m = 0.0;
  /// Noise of a corrected reading: sigma_m + sigma_per_m2 * depth^2 (Khoshelham and Elberink 2012).
  double sigma_m = 0.0, sigma_per_m2 = 0.0;
  SE3 color_from_depth;                ///< Estimated; where depth is registered, what it is off by.
  std::optional<Camera> depth_camera;  ///< Where depth is not registered.
  double rotation_sigma_rad = 0.0;     ///< The largest of three.
  double translation_sigma_m = 0.0;
  double nearest_m = 0.0, farthest_m = 0.0;  ///< Of the boards.
  std::vector<std::string> doubts;           ///< One plain line each.
};

/// Scale, offset, noise and registration of depth from the planes of boards (as Herrera et al. 2012, without a
/// distortion of depth): each reading on a board, moved into the color camera, lies in its plane. Standard deviations
/// are from the scatter between boards, since the readings of one share its errors. Throws Error for fewer than 3
/// boards with depth, and for boards at one distance only, from which scale and offset cannot be told apart.
DepthCalibration calibrate_depth(const DepthCalibrationInput& input);

/// How the depth was read that was calibrated.
struct DepthAsRead {
  double units_per_meter = 0.0;                   ///< Of the raw readings.
  double offset_m = 0.0;                          ///< Added to each.
  std::optional<DepthRegistration> registration;  ///< That put it into the color image.
};

/// In words.
std::string depth_summary(const DepthCalibration& calibration);
/// The keys that rastro reads beside a camera's calibration: depth_factor and depth_offset_m of the raw readings, given
/// those the depth was read with, and where the device does not register depth depth_camera and color_from_depth; also
/// the noise.
std::string depth_calibration_text(const DepthCalibration& calibration, const DepthAsRead& read);

}  // namespace rastro
