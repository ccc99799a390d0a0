// SPDX-License-Identifier: Apache-2.0
// EuRoC's lists of images, positions and sensor poses: whatever the text, they are read or refused with rastro::Error.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/dataset/euroc/euroc.h"

namespace {

template <typename Read>
void refuse_or_read(Read read) {
  try {
    read();
  } catch (const rastro::Error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  refuse_or_read([&] {
    const auto list = rastro::parse_euroc_image_list(text, "input");
    if (list.images.empty()) __builtin_trap();
    rastro::associate(list.images, list.images, 1'000'000);
  });
  refuse_or_read([&] { rastro::parse_leica_positions(text, "input"); });
  refuse_or_read([&] { rastro::parse_sensor_pose(text, "input"); });
  return 0;
}
