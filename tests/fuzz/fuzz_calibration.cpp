// SPDX-License-Identifier: Apache-2.0
// Calibration files of every format: whatever the text, the readers return or throw rastro::Error, and what they return
// can be used.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/camera/calibration_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const rastro::Calibration calibration = rastro::parse_calibration(text, "input");
    if (calibration.cameras.empty()) __builtin_trap();
    for (const auto& entry : calibration.cameras) {
      rastro::calibration_warnings(entry.camera);
      if (const auto ray = entry.camera.unproject({10.0, 20.0})) entry.camera.project({ray->x(), ray->y(), 1.0});
    }
  } catch (const rastro::Error& error) {
    if (std::string_view(error.what()).find('\n') != std::string_view::npos) __builtin_trap();
  }
  try {
    rastro::parse_kitti_transform(text, "input");
  } catch (const rastro::Error&) {
  }
  return 0;
}
