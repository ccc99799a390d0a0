// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "rastro/base/time.h"

namespace rastro::cli {

/// What a run says of one frame.
struct RunFrame {
  std::int64_t frame = 0;  ///< Number in the recording.
  TimeNs stamp = 0;
  bool tracked = false;  ///< Its pose was measured: state tracking, weak or relocalized.
  std::string state, reason;
};

/// The lines of stats.csv, in the order of the run. Error where it is missing or broken.
std::vector<RunFrame> read_run_frames(const std::filesystem::path& stats_csv);

/// Whether a frame of about this stamp was tracked; files give stamps with fewer digits than frames have.
bool was_tracked(const std::vector<RunFrame>& frames, TimeNs stamp);

}  // namespace rastro::cli
