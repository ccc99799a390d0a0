// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace rastro {

/// Which frames of an endless world a recording has: frames first, first + every, and so on.
struct FrameSelection {
  std::int64_t first = 0;
  std::int64_t every = 1;

  /// Frame of the world that is number `index` of the recording.
  std::int64_t frame(std::int64_t index) const { return first + index * every; }
};

}  // namespace rastro
