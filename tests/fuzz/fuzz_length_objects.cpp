// SPDX-License-Identifier: Apache-2.0
// Lengths to measure: whatever the text, they are read or refused with rastro::Error; what is read can be measured.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/evaluate/map_lengths.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto read = rastro::parse_length_objects({reinterpret_cast<const char*>(data), size}, "input");
    rastro::PointCloud cloud;
    for (int k = 0; k < 64; ++k) {
      cloud.points.emplace_back();
      cloud.points.back().position = {0.02F * static_cast<float>(k % 8), 0.02F * static_cast<float>(k / 8), 1.0F};
    }
    for (const auto& measured : rastro::measure_lengths(cloud, read.objects, {}))
      if (measured.length_m && !(std::isfinite(*measured.length_m) && measured.sigma_m > 0.0)) __builtin_trap();
  } catch (const rastro::Error&) {
  }
  return 0;
}
