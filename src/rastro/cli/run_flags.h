// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "rastro/base/options.h"
#include "rastro/cli/common_flags.h"
#include "rastro/cli/server_flags.h"

namespace rastro::cli {

/// The flags of live sources.
struct LiveFlags {
  double speed = 1.0;   ///< --speed; of a replay
  bool loop = false;    ///< --loop; of a replay
  int queue = 8;        ///< --queue, frames
  bool drains = false;  ///< No flag: after Ctrl-C what waits in the queue is still taken.
  std::string record;   ///< --record DIR; empty: nothing is recorded
};

/// The flags that mean the same in every subcommand that runs something with an option table.
struct RunFlags {
  DataFlags data;
  LiveFlags live;
  std::string out;
  std::string preset;  ///< Empty: the defaults.
  std::string options_file;
  std::vector<std::string> settings;      ///< --set key=value
  std::vector<std::string> disturbances;  ///< --disturb NAME[=VALUE]
  bool force = false;
  bool seed_given = false;
  bool view = false;
  ServerFlags server;  ///< Of --view.
  std::string mcap;    ///< --mcap; empty: none.
};

/// --options and --set; `options_command` prints the options: "rastro options METHOD".
void add_settings_flags(CLI::App& command, RunFlags& flags, const std::string& group,
                        const std::string& options_command);
/// --preset
void add_preset_flag(CLI::App& command, RunFlags& flags, const std::string& group, const std::string& which);
/// --disturb, which only `rastro benchmark --help` documents: it makes the input wrong on purpose.
void add_disturbance_flag(CLI::App& command, RunFlags& flags);
/// --out and --force.
void add_folder_flags(CLI::App& command, RunFlags& flags);
/// --view, and where it is served.
void add_view_flags(CLI::App& command, RunFlags& flags);
/// --mcap
void add_mcap_flag(CLI::App& command, RunFlags& flags);

/// Opens the recording, disturbed as the flags say.
std::unique_ptr<Source> open_disturbed(const RunFlags& flags, const OpenOptions& options);

/// Whether --preset names one of `presets`; not so where it is empty or "default". Error for any other name; `owner` is
/// what has the presets: "the tracker".
bool is_preset(const std::string& name, const std::string& owner, const std::vector<std::string>& presets);
/// Sets the table from the options file, then from --set.
void apply_given_settings(const RunFlags& flags, OptionTable& table);
/// Sets the option `seed` where --seed is given.
void apply_given_seed(const RunFlags& flags, OptionTable& table);

}  // namespace rastro::cli
