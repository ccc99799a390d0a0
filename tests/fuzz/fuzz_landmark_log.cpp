// SPDX-License-Identifier: Apache-2.0
// A landmark log of rastro's own form or of MRCLAM: read or refused with rastro::Error, its frames in order.
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/dataset/landmark_log/landmark_log.h"

namespace {

void check_frames(const rastro::LandmarkLog& log) {
  rastro::TimeNs last = std::numeric_limits<rastro::TimeNs>::min();
  for (const auto& frame : rastro::landmark_frames(log)) {
    if (frame.stamp < last || frame.landmarks.empty()) __builtin_trap();
    if (frame.odometry_from_body && !frame.odometry_from_body->translation().allFinite()) __builtin_trap();
    last = frame.stamp;
  }
}

template <typename Read>
void read_or_refuse(Read read) {
  try {
    read();
  } catch (const rastro::Error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  read_or_refuse([&] { check_frames(rastro::parse_landmark_log(text, "input")); });
  read_or_refuse([&] {
    rastro::LandmarkLog log;
    rastro::parse_mrclam_odometry(log, text, "input");
    rastro::parse_mrclam_measurements(log, rastro::parse_mrclam_barcodes(text, "input"), text, "input");
    check_frames(log);
  });
  read_or_refuse([&] { rastro::parse_mrclam_ground_truth(text, "input"); });
  return 0;
}
