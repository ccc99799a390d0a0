// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "rastro/track/options.h"

namespace rastro::cli {

/// What a run folder of `rastro track` says of how it was made. What is not there keeps its default.
struct TrackRunInput {
  std::string data_path;  ///< DATA of the run; empty where there is no about.json.
  int image_width = 0;    ///< 0: not known.
  int image_height = 0;
  TrackOptions options;
};

/// `run` is a run folder or one of its files.
TrackRunInput read_run_input(const std::filesystem::path& run);

}  // namespace rastro::cli
