// SPDX-License-Identifier: Apache-2.0
// Trajectories of every format: whatever the text, they are read or refused with rastro::Error; what is read can be
// asked for poses.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/evaluate/pose_consistency.h"
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
  const auto ask = [](const rastro::Trajectory& trajectory) {
    if (trajectory.empty()) __builtin_trap();
    const auto& first = trajectory.front();
    if (!rastro::pose_at(trajectory, first.stamp, 0)) __builtin_trap();
    rastro::pose_at(trajectory, first.stamp / 2 + trajectory.back().stamp / 2, INT64_MAX);
  };
  refuse_or_read([&] { rastro::guess_trajectory_format(text, "input"); });
  refuse_or_read([&] { ask(rastro::parse_tum_trajectory(text, "input")); });
  refuse_or_read([&] { ask(rastro::parse_euroc_trajectory(text, "input")); });
  refuse_or_read([&] { rastro::parse_kitti_poses(text, "input"); });
  refuse_or_read([&] { rastro::parse_pose_covariances(text, "input"); });
  return 0;
}
