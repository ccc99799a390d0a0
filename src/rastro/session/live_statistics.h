// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rastro/session/time_histogram.h"

namespace rastro {

/// What was recorded beside a live run.
struct RecordingStatistics {
  std::int64_t frames = 0;   ///< Written.
  std::int64_t dropped = 0;  ///< Left out because writing was too slow.
  std::string failure;       ///< Why recording ended before the run; empty if it did not.
};

/// What a live run counts.
struct LiveStatistics {
  std::int64_t arrived = 0;
  std::int64_t dropped = 0;  ///< The oldest that waited, because the method was too slow.
  std::int64_t lost = 0;     ///< By the device, before they arrived.
  std::int64_t stalls = 0;   ///< Times that the source was there, but gave nothing.
  std::int64_t losses = 0;   ///< Times that it was gone.
  TimeHistogram exposure_to_pose;
  std::optional<RecordingStatistics> recording;  ///< With --record.
};

/// For limits (--require): "live_dropped_frames", ...
std::vector<std::pair<std::string, double>> numbers_of(const LiveStatistics& statistics);
/// "0 of 1200 frames dropped; exposure to pose 12.1 ms (median), 95 % within 20.3 ms; runs may differ"
std::string summary_of(const LiveStatistics& statistics);

}  // namespace rastro
