// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/depth_readings.h"

#include "rastro/camera/calibration_file.h"
#include "rastro/dataset/tum_rgbd/depth_factor.h"

namespace rastro {

DepthReadings depth_readings(const OpenOptions& options, double own_units_per_meter) {
  DepthReadings readings;
  readings.device_registers = !options.raw_depth;
  if (options.calibration_file.empty()) return readings;
  if (const auto factor = read_depth_factor(options.calibration_file)) {
    readings.scale = own_units_per_meter / factor->units_per_meter;
    readings.offset_m = factor->offset_m;
  }
  if (read_calibration(options.calibration_file).depth) readings.device_registers = false;
  return readings;
}

}  // namespace rastro
