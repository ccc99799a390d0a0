// SPDX-License-Identifier: Apache-2.0
// KITTI's times.txt and timestamps.txt: whatever the text, they are read or refused with rastro::Error.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/dataset/kitti/kitti_raw.h"
#include "rastro/sensor/trajectory_file.h"

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
    if (rastro::parse_kitti_times(text, "input").empty()) __builtin_trap();
  });
  refuse_or_read([&] {
    if (rastro::parse_kitti_timestamps(text, "input").empty()) __builtin_trap();
  });
  return 0;
}
