// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/dataset/open.h"

namespace rastro {

/// What becomes of the readings of a depth camera.
struct DepthReadings {
  double scale = 1.0, offset_m = 0.0;  ///< true depth = scale * reading + offset_m.
  /// The device is to put depth into its color image, where it can; else rastro does, or nobody.
  bool device_registers = true;

  /// Meters of a reading in meters; 0 (none) stays so.
  float corrected(float reading) const {
    return reading > 0.0F ? static_cast<float>(scale * static_cast<double>(reading) + offset_m) : 0.0F;
  }
};

/// As `rastro calibrate --depth` wrote them: depth_factor (of readings in millimeters), depth_offset_m and depth_camera
/// of the calibration file, where one is given. `own_units_per_meter`: of the device. Error for a file that cannot be
/// read.
DepthReadings depth_readings(const OpenOptions& options, double own_units_per_meter);

}  // namespace rastro
