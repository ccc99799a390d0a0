// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <string>

#include "rastro/sensor/source.h"

namespace rastro {

/// EuRoC's sensor.yaml, and the YAML of OpenCV and ROS; `camera` is calibrated. read_calibration() gives the same
/// numbers.
std::string euroc_calibration_text(const CalibratedCamera& camera, const SE3& body_from_camera);
std::string opencv_calibration_text(const CalibratedCamera& camera);

}  // namespace rastro
