// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/run_flags.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/synthetic/disturbance/disturbance.h"

namespace rastro::cli {

void add_settings_flags(CLI::App& command, RunFlags& flags, const std::string& group,
                        const std::string& options_command) {
  command.add_option("--options", flags.options_file, "YAML file of options; see '" + options_command + " --yaml'")
      ->type_name("FILE")
      ->group(group);
  command.add_option("--set", flags.settings, "Set an option; may be repeated; see '" + options_command + "'")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false)
      ->group(group);
}

void add_preset_flag(CLI::App& command, RunFlags& flags, const std::string& group, const std::string& which) {
  command
      .add_option("--preset", flags.preset,
                  "Values of the settings to begin with: 'default', or 'paper' (" + which + ")")
      ->type_name("NAME")
      ->group(group);
}

void add_disturbance_flag(CLI::App& command, RunFlags& flags) {
  command.add_option("--disturb", flags.disturbances, "Make the input wrong on purpose; see 'rastro benchmark --help'")
      ->type_name("NAME[=VALUE]")
      ->allow_extra_args(false)
      ->group("");  // hidden
}

std::unique_ptr<Source> open_disturbed(const RunFlags& flags, const OpenOptions& options) {
  for (const std::string& each : flags.disturbances) check_disturbance(each);
  auto source = rastro::open(flags.data.path, options);
  for (const std::string& each : flags.disturbances) source = disturbed(std::move(source), each);
  return source;
}

void add_folder_flags(CLI::App& command, RunFlags& flags) {
  const char* group = "Output";
  command.add_option("--out", flags.out, "Output folder")->type_name("DIR")->required()->group(group);
  command.add_flag("--force", flags.force, "Overwrite a former run in --out")->group(group);
}

void add_view_flags(CLI::App& command, RunFlags& flags) {
  const char* group = "Viewer";
  command.add_flag("--view", flags.view, "Show the run in a browser while it goes on; prints the address")
      ->group(group);
  add_server_flags(command, flags.server, group);
}

void add_mcap_flag(CLI::App& command, RunFlags& flags) {
  command
      .add_option("--mcap", flags.mcap,
                  "Write the run as it goes on as an MCAP file, for Foxglove, Lichtblick and Rerun: poses as first "
                  "estimated, events, images of keyframes; trajectory and map at the end")
      ->type_name("FILE")
      ->group("Output");
}

bool is_preset(const std::string& name, const std::string& owner, const std::vector<std::string>& presets) {
  if (name.empty() || name == "default") return false;
  if (std::find(presets.begin(), presets.end(), name) != presets.end()) return true;
  throw Error(fmt::format("{} has no preset '{}'", owner, one_line(name)), "--preset",
              presets.empty() ? "omit it" : fmt::format("use default or {}", fmt::join(presets, ", ")));
}

void apply_given_settings(const RunFlags& flags, OptionTable& table) {
  if (!flags.options_file.empty()) table.load_yaml(flags.options_file);
  for (const std::string& setting : flags.settings) table.set_assignment(setting, "--set");
}

void apply_given_seed(const RunFlags& flags, OptionTable& table) {
  if (flags.seed_given) table.set("seed", fmt::format("{}", flags.data.seed), "--seed");
}

}  // namespace rastro::cli
