// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/camera/calibration_file.h"

namespace rastro {

/// Calibrations as text; read_calibration() gives the same numbers. Cameras need a size.
/// ROS's camera_info YAML of one camera: with its rectification and projection, those of a pair where `pair` has two.
std::string ros_calibration_text(const std::vector<CalibratedCameraEntry>& pair, std::size_t camera);
/// The keys of a depth camera beside that of a ROS or OpenCV file, to be put at its end.
std::string depth_registration_text(const DepthRegistration& depth);
/// OpenCV's FileStorage YAML: camera_matrix and distortion_coefficients of one camera; of a pair M1 D1 M2 D2, and R T
/// (right from left).
std::string opencv_calibration_text(const std::vector<CalibratedCameraEntry>& cameras);
/// Whether Kalibr has their models: without a third radial coefficient, and not the rational one.
bool has_kalibr_form(const std::vector<CalibratedCameraEntry>& cameras);

/// Kalibr's camchain, each camera relative to the one before. Error for a model that it does not have.
std::string kalibr_calibration_text(const std::vector<CalibratedCameraEntry>& cameras);

}  // namespace rastro
