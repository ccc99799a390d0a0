// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>

#include "rastro/dataset/open.h"

namespace rastro {

/// What becomes of the readings of a source that gives depth in meters: a depth camera or a ROS bag.
struct DepthReadings {
  double scale = 1.0, offset_m = 0.0;  ///< true depth = scale * reading + offset_m.
  /// The device is to put depth into its color image, where it can; else rastro does, or nobody.
  bool device_registers = true;
  double units_per_meter = 1000.0;  ///< Of the raw readings, by the calibration.
  std::string warning;              ///< Empty: none.

  /// Meters of a reading in meters; 0 (none) stays so.
  float corrected(float reading) const {
    if (reading <= 0.0F) return 0.0F;
    return std::max(0.0F, static_cast<float>(scale * static_cast<double>(reading) + offset_m));
  }
};

/// As `rastro calibrate --depth` wrote them: depth_factor, depth_offset_m and depth_camera of the calibration file,
/// where one is given. `own_units_per_meter`: of the source. A depth_factor more than a quarter away from it is that of
/// other recordings (5000 in TUM's): it is not used, with a warning. Error for a file that cannot be read.
DepthReadings depth_readings(const OpenOptions& options, double own_units_per_meter);

/// A source with these readings.
void describe_depth(const DepthReadings& readings, SourceInfo& info);

}  // namespace rastro
