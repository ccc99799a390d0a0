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
  map.rastro             the map, kept safe as the run goes: for 'rastro info', 'rastro export', 'rastro localize'
  map.png                the map from above with the trajectory
  map.pgm map.yaml       of laser scans: the occupancy grid as ROS's map_server reads it
  cloud.ply              of a depth camera's images: colored point cloud
  keyframes.txt          of features: final pose of each keyframe
  landmarks.csv          of a filter: position, covariance and number of observations of each landmark
  stats.csv    state, reason, score, times of each stage per frame    events.jsonl  changes of state with reasons, loops
  options.yaml all values in force    about.json  version, machine, input    result.json  coverage, states, times, hash

Examples:
  rastro slam intel.clf.gz --method hector --out run
  rastro slam intel.clf.gz --method hector --out odometry_off --guess none --loop-closing false
  rastro slam rgbd_dataset_freiburg1_room --method rgbd --out room --max-memory 600MB
  rastro slam sequences/00 --method orb --sensor mono --out run     one camera: lengths in a unit of their own,
  rastro scale run --camera-height 1.65                             which this makes metres
  rastro slam sequences/00_again --map run --continue --out longer
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

constexpr const char* localize_footer = R"(
MAP is made by 'rastro slam DATA --method rgbd' or orb. The recording may be another one, by the same kind of camera.

Writes into --out:
  trajectory.txt   pose of every frame that was found: stamp tx ty tz qx qy qz qw in the frame and unit of the map
  stats.csv, events.jsonl, options.yaml, about.json, result.json   as 'rastro slam' does; in result.json:
    recall                 frames whose place was seen, neither lost nor carried on, in percent of those asked for
    seconds_to_first_pose  of the recording, until the first of them; -1 where there was none

Examples:
  rastro localize kitchen_again --map run --out found
  rastro localize kitchen_again --map kitchen.rastro --out found --require 'recall>=95')";

void add_run_flags(CLI::App& command, SlamFlags& flags, const char* group) {
  add_settings_flags(command, flags, group, "rastro options METHOD");
  command
      .add_option("--mode", flags.mode,
                  "'pipelined': mapping runs beside tracking; 'step': one after the other, with the same results")
      ->type_name("MODE")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--mask", flags.mask,
                  "Image (or folder of one per frame), black where nothing may be used, as on the camera's carrier")
      ->type_name("FILE")
      ->group(group);
  command
      .add_option("--max-memory", flags.max_memory,
                  "Memory of the whole program, such as 600MB; the method makes do with it, or the run ends before")
      ->type_name("SIZE")
      ->group(group);
}

void add_output_flags(CLI::App& command, SlamFlags& flags, const std::string& example) {
  add_folder_flags(command, flags);
  command
      .add_option("--require", flags.limits,
                  "Limit on a number of result.json, such as '" + example + "'; exit code 1 when one is missed")
      ->type_name("LIMIT")
      ->allow_extra_args(false)
      ->group("Output");
}

void add_method_flags(CLI::App& command, SlamFlags& flags) {
  const char* group = "SLAM";
  command.add_option("--method", flags.method, "Which one; see below (default with --map: that of the map)")
      ->group(group);
  command
      .add_option("--map", flags.map, "With --continue: map file of landmarks, or the folder of the run that made it")
      ->type_name("MAP")
      ->group(group);
  command.add_flag("--continue", flags.extend, "Go on with the map of --map; the longer one is written into --out")
      ->group(group);
  command.add_option("--sensor", flags.sensor, "What to use of the recording (option sensor): all it has, or less")
      ->type_name("mono|stereo|rgbd")
      ->group(group);
  command.add_option("--frontend", flags.frontend, "How points are found from frame to frame (option frontend)")
      ->type_name("orb|tracks")
      ->group(group);
  command.add_option("--guess", flags.guess, "Where the next pose is first looked for (option guess of the method)")
      ->group(group);
  command.add_option("--loop-closing", flags.loop_closing, "Whether places are recognised (option loop_closing)")
      ->type_name("true|false")
      ->group(group);
  add_run_flags(command, flags, group);
}

}  // namespace

void add_slam_flags(CLI::App& command, SlamFlags& flags) {
  add_data_flags(command, flags.data);
  add_method_flags(command, flags);
  add_output_flags(command, flags, "coverage>=95");
  command.footer(methods_text() + footer);
}

void add_localize_flags(CLI::App& command, SlamFlags& flags) {
  add_data_flags(command, flags.data);
  command.add_option("--map", flags.map, "Map file, or the folder of the run that made it")
      ->type_name("MAP")
      ->required()
      ->group("Map");
  add_run_flags(command, flags, "Map");
  add_output_flags(command, flags, "recall>=95");
  command.footer(localize_footer);
}

void apply_settings(const SlamFlags& flags, OptionTable& table) {
  apply_given_settings(flags, table);
  set_from_flag(table, "guess", flags.guess, "--guess", flags.method);
  set_from_flag(table, "sensor", flags.sensor, "--sensor", flags.method);
  set_from_flag(table, "frontend", flags.frontend, "--frontend", flags.method);
  set_from_flag(table, "loop_closing", flags.loop_closing, "--loop-closing", flags.method);
  // A method without a seed draws nothing at random: any seed gives its result.
  if (has_option(table, "seed")) apply_given_seed(flags, table);
}

}  // namespace rastro::cli
