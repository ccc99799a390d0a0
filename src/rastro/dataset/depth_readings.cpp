// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/depth_readings.h"

#include <fmt/format.h>

#include "rastro/camera/calibration_file.h"
#include "rastro/camera/depth_registration.h"
#include "rastro/dataset/tum_rgbd/depth_factor.h"

namespace rastro {
DepthReadings depth_readings(const OpenOptions& options, double own_units_per_meter) {
  DepthReadings readings;
  readings.device_registers = !options.raw_depth;
  readings.units_per_meter = own_units_per_meter;
  if (options.calibration_file.empty()) return readings;
  if (read_calibration(options.calibration_file).depth) readings.device_registers = false;
  const auto factor = read_depth_factor(options.calibration_file);
  if (!factor) return readings;
  const double scale = own_units_per_meter / factor->units_per_meter;
  if (scale > largest_depth_correction || scale < 1.0 / largest_depth_correction) {
    readings.warning = fmt::format("{}: depth_factor {:g} is not used: the readings here are taken as {:g} a meter",
                                   options.calibration_file, factor->units_per_meter, own_units_per_meter);
    return readings;
  }
  readings.scale = scale;
  readings.offset_m = factor->offset_m;
  readings.units_per_meter = factor->units_per_meter;
  return readings;
}

void describe_depth(const DepthReadings& readings, SourceInfo& info) {
  info.has_depth = true;
  info.depth_factor = readings.units_per_meter;
  info.depth_offset_m = readings.offset_m;
  if (!readings.warning.empty()) info.warnings.push_back(readings.warning);
}

}  // namespace rastro
