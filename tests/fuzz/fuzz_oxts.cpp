// SPDX-License-Identifier: Apache-2.0
// A GPS/IMU packet of KITTI raw: whatever the text, it is read or refused with rastro::Error, and gives a valid pose.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/dataset/kitti/oxts.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const std::array packets = {
        rastro::parse_oxts_packet({reinterpret_cast<const char*>(data), size}, "input"),
    };
    for (const rastro::SE3& pose : rastro::oxts_poses(packets)) {
      if (!pose.matrix().allFinite()) __builtin_trap();
    }
  } catch (const rastro::Error&) {
  }
  return 0;
}
