// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "rastro/track/options.h"

namespace rastro::cli {

/// Input and options of a run of `rastro track`, read from its folder. What is missing keeps its default.
struct TrackRunInput {
  std::string data_path;  ///< DATA of the run; empty where there is no about.json.
  int image_width = 0;    ///< 0: unknown.
  int image_height = 0;
  TrackOptions options;
};

/// `run` is a run folder or one of its files.
TrackRunInput read_run_input(const std::filesystem::path& run);

}  // namespace rastro::cli
