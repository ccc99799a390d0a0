// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/slam_flags.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/methods/methods.h"

namespace rastro::cli {
namespace {

constexpr const char* footer = R"(
Writes into --out:
  trajectory.txt         final pose of every frame: stamp tx ty tz qx qy qz qw, world_from_body, metres
  trajectory_online.txt  each pose as first given; covariance_online.txt: how well it was known, where the method says so
  map.pgm map.yaml       the map as ROS's map_server reads it    map.png  the same with the way drawn in
  landmarks.csv          place, covariance and number of sightings of each landmark, where the method has landmarks
  stats.csv    state, reason, score, times of each stage per frame    events.jsonl  changes of state with reasons, loops
  options.yaml all values in force    about.json  version, machine, input    result.json  coverage, states, times, hash

Examples:
  rastro slam intel.clf.gz --method hector --out run
  rastro slam intel.clf.gz --method hector --out odometry_off --guess none --loop-closing false
  rastro slam corridor --method ekf --out run --require 'coverage>=99'
  rastro evaluate relations run --relations intel.relations
  rastro evaluate map run/map.yaml corridor/floor_plan.yaml)";

std::string methods_text() {
  std::string text = "Methods:\n";
  for (const auto& method : slam_methods())
    text += fmt::format("  {:<10} {}\n  {:<10}   needs {}\n", method->name(), method->summary(), "", method->needs());
  return text;
}

bool has_option(const OptionTable& table, const std::string& name) {
  const auto& options = table.options();
  return std::any_of(options.begin(), options.end(), [&](const Option& option) { return option.name == name; });
}

/// A flag for one option of some methods.
void set_from_flag(OptionTable& table, const std::string& name, const std::string& value, const std::string& flag,
                   const std::string& method) {
  if (value.empty()) return;
  if (!has_option(table, name)) {
    throw Error(fmt::format("the method '{}' has no option '{}'", method, name), flag,
                fmt::format("leave it away; 'rastro options {}' lists what there is", method));
  }
  table.set(name, value, flag);
}

void add_method_flags(CLI::App& command, SlamFlags& flags) {
  const char* group = "SLAM";
  command.add_option("--method", flags.method, "Which one; see below")->required()->group(group);
  command.add_option("--guess", flags.guess, "Where the next pose is first looked for (option guess of the method)")
      ->group(group);
  command.add_option("--loop-closing", flags.loop_closing, "Whether places are recognised (option loop_closing)")
      ->type_name("true|false")
      ->group(group);
  command.add_option("--options", flags.options_file, "YAML file with settings; see 'rastro options METHOD --yaml'")
      ->type_name("FILE")
      ->group(group);
  command.add_option("--set", flags.settings, "Set one option, may be repeated; see 'rastro options METHOD'")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false)
      ->group(group);
}

}  // namespace

void add_slam_flags(CLI::App& command, SlamFlags& flags) {
  add_data_flags(command, flags.data);
  add_method_flags(command, flags);
  command.add_option("--out", flags.out, "Folder for the results")->type_name("DIR")->required()->group("Output");
  command.add_flag("--force", flags.force, "Write into a folder that is not empty, replacing a former run")
      ->group("Output");
  command
      .add_option("--require", flags.limits,
                  "Limit on a number of result.json, such as 'coverage>=95'; exit code 1 when one is missed")
      ->type_name("LIMIT")
      ->allow_extra_args(false)
      ->group("Output");
  command.footer(methods_text() + footer);
}

void apply_settings(const SlamFlags& flags, OptionTable& table) {
  if (!flags.options_file.empty()) table.load_yaml(flags.options_file);
  for (const std::string& setting : flags.settings) table.set_assignment(setting, "--set");
  set_from_flag(table, "guess", flags.guess, "--guess", flags.method);
  set_from_flag(table, "loop_closing", flags.loop_closing, "--loop-closing", flags.method);
  // A method without a seed draws nothing at random: any seed gives its result.
  if (flags.seed_given && has_option(table, "seed")) table.set("seed", fmt::format("{}", flags.data.seed), "--seed");
}

}  // namespace rastro::cli
