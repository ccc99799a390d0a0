// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rastro/base/options.h"
#include "rastro/cli/run_flags.h"
#include "rastro/track/options.h"

namespace rastro::cli {

/// The flags of `rastro track`.
struct TrackFlags : RunFlags {
  std::string mode, features, window, validation;  ///< Empty: not given; they set the options of the same names.
  std::string mask;
  bool images = false;
  std::string match_image;  ///< A:B
  std::string table;        ///< A:B
  std::string video;
  std::vector<std::string> formats = {"yaml", "csv", "jsonl"};
  std::vector<std::string> limits;  ///< --require
};

void add_track_flags(CLI::App& command, TrackFlags& flags);

/// The values of --preset. Error for an unknown one.
void apply_preset(const TrackFlags& flags, TrackOptions& options);

/// Sets the table from the options file, --set and the flags, in this order. Errors name the flag.
void apply_settings(const TrackFlags& flags, OptionTable& table);

/// The frames of --match-image; nullopt when not given.
std::optional<std::pair<std::int64_t, std::int64_t>> match_frames(const TrackFlags& flags);

/// First and end of the frames of --table; nullopt when not given.
std::optional<std::pair<std::int64_t, std::int64_t>> table_frames(const TrackFlags& flags);

}  // namespace rastro::cli
