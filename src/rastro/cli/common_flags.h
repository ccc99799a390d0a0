// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/dataset/open.h"

namespace rastro::cli {

/// The flags that mean the same in every subcommand that reads data.
struct DataFlags {
  std::string path;                 ///< DATA
  std::string frames;               ///< --frames A:B (B not included; either may be empty)
  int every = 1;                    ///< --every N
  std::optional<double> rate_hz;    ///< --rate HZ, where stamps are missing
  std::string camera;               ///< --camera NAME: which camera of the data (default: the left or only one)
  double fov_deg = 0.0;             ///< --fov DEG, horizontal; 0 = not given
  std::string intrinsics;           ///< --intrinsics fx,fy,cx,cy
  std::string calibration;          ///< --calibration FILE
  double readout_s = -1.0;          ///< --readout-time S; negative: not given
  double calibration_error = -1.0;  ///< --calibration-error SHARE; negative: not given
  int threads = 0;                  ///< --threads N, 0: all cores
  std::uint64_t seed = 1;           ///< --seed N
  bool json = false;                ///< --json
  bool quiet = false;               ///< --quiet
};

/// "A:B" of --frames; empty: all. Error for anything else.
void set_frames(const std::string& text, OpenOptions& options);
void add_data_flags(CLI::App& command, DataFlags& flags);
/// Error for values out of range, naming the flag.
OpenOptions open_options(const DataFlags& flags);

}  // namespace rastro::cli
