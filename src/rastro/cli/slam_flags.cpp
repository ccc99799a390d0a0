// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/slam_flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/cli/live_flags.h"
#include "rastro/methods/methods.h"

namespace rastro::cli {
namespace {

constexpr const char* slam_footer = R"(
Output files, in --out:
  trajectory.txt         final pose of every frame, TUM format: timestamp tx ty tz qx qy qz qw, world_from_body; meters,
                         or up to scale with one camera: --sensor mono, or orb on a recording of one camera
  trajectory_online.txt  pose of every frame as first estimated, without later corrections
  covariance_online.txt  covariance of each of these poses, of methods that estimate it
  map.rastro             the map, for 'rastro info', 'export', 'localize', 'measure'; kept up to date during the run
  map.png                the map from above with the trajectory
  map.pgm map.yaml       2D laser: occupancy grid in the format of ROS map_server
  cloud.ply              rgbd, rtabmap: colored point cloud
  places.png             rtabmap: probability of places keyframe by keyframe, with matches and rejections
  keyframes.txt          orb: final pose of every keyframe, TUM format
  landmarks.csv          ekf: position, covariance and number of observations of every landmark
  stats.csv              state, reason, score and stage times per frame
  events.jsonl           changes of state with reasons, loop closures
  options.yaml           options in use
  about.json             version, machine, input, command line
  result.json            coverage (% of the requested frames with a pose), states, times, memory, hash of the result

Examples:
  rastro slam intel.clf.gz --method hector --out run
  rastro slam intel.clf.gz --method hector --out scan_matching_only --guess none --loop-closing false
  rastro slam rgbd_dataset_freiburg1_room --method rgbd --out room --max-memory 600MB
  rastro slam sequences/00 --method orb --sensor mono --out run     one camera: up to scale
  rastro scale run --camera-height 1.65                             makes it metric
  rastro slam replay:sequences/00 --method orb --out run            at its own pace, as from a camera
  rastro slam sequences/00_again --map run --continue --out longer
  rastro slam corridor --method ekf --out run --require 'coverage>=99'
  rastro slam corridor --method hector --out run --initial-pose 12.5,3,90      in the frame of a floor plan
  rastro evaluate relations run --relations intel.relations
  rastro evaluate map run corridor/floor_plan.yaml)";

[[noreturn]] void refuse_initial_pose(const std::string& text, bool planar) {
  throw Error(in_quotes(text) + " is not a pose", "--initial-pose",
              planar ? "give x,y,yaw in meters and degrees, such as 2.5,-1,90"
                     : "give x,y,z or x,y,z,roll,pitch,yaw in meters and degrees, such as 2.5,-1,0,0,0,90");
}

std::string methods_text() {
  std::string text = "Methods:\n";
  for (const auto& method : selectable_slam_methods())
    text += fmt::format("  {:<10} {}\n  {:<10}   input: {}\n", method->name(), method->summary(), "", method->needs());
  return text;
}

bool has_option(const OptionTable& table, const std::string& name) {
  const auto& options = table.options();
  return std::any_of(options.begin(), options.end(), [&](const Option& option) { return option.name == name; });
}

/// Sets an option that not every method has.
void set_from_flag(OptionTable& table, const std::string& name, const std::string& value, const std::string& flag,
                   const std::string& method) {
  if (value.empty()) return;
  if (!has_option(table, name)) {
    throw Error(fmt::format("the method '{}' has no option '{}'", method, name), flag,
                method == "auto" ? "add --method NAME: it is for one method"
                                 : fmt::format("omit it; 'rastro options {}' lists the options", method));
  }
  table.set(name, value, flag);
}

constexpr const char* localize_footer = R"(
MAP is a map of 'rastro slam DATA --method rgbd', rtabmap, orb or fusion. DATA may be another recording, of the same kind of camera.

Output files, in --out:
  trajectory.txt   pose of every localized frame, TUM format, in the frame and unit of the map
  stats.csv, events.jsonl, options.yaml, about.json, result.json   as of 'rastro slam'; in result.json:
    recall                 % of the requested frames that were localized: neither lost nor predicted only
    seconds_to_first_pose  time in the recording until the first localized frame; -1 if there is none

Examples:
  rastro localize kitchen_again --map run --out found
  rastro localize kitchen_again --map kitchen.rastro --out found --require 'recall>=95'
  rastro localize kitchen_again --map run --out found --initial-pose 1.2,0.4,0,0,-30,0      search there first)";

void add_run_flags(CLI::App& command, SlamFlags& flags, const char* group) {
  add_preset_flag(command, flags, group, "rtabmap, lsd: those of the publication");
  add_settings_flags(command, flags, group, "rastro options METHOD");
  add_disturbance_flag(command, flags);
  command
      .add_option(
          "--mode", flags.mode,
          "'pipelined': mapping in parallel with tracking; 'step': one after the other; the results are the same")
      ->type_name("MODE")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--mask", flags.mask,
                  "Mask image, or folder of one per frame: nothing is used where it is black, such as the robot itself")
      ->type_name("FILE")
      ->group(group);
  command
      .add_option("--max-memory", flags.max_memory,
                  "Memory limit of the program, such as 600MB (default: none): keyframes get sparser as the map fills "
                  "its share; if that does not suffice, the run ends")
      ->type_name("SIZE")
      ->group(group);
  command
      .add_option("--initial-pose", flags.initial_pose,
                  "Pose of the body at the first frame, in meters and degrees; x,y,yaw for hector and ekf (default: "
                  "identity; in a given map: unknown)")
      ->type_name("x,y,z[,roll,pitch,yaw]")
      ->group(group);
}

void add_output_flags(CLI::App& command, SlamFlags& flags, const std::string& example) {
  add_folder_flags(command, flags);
  command
      .add_option("--require", flags.limits,
                  "Limit on a value of result.json, such as '" + example + "'; exit code 1 if missed; may be repeated")
      ->type_name("LIMIT")
      ->allow_extra_args(false)
      ->group("Output");
  add_mcap_flag(command, flags);
}

void add_sensor_flag(CLI::App& command, SlamFlags& flags, const char* group) {
  command
      .add_option("--sensor", flags.sensor,
                  "Sensor to use: mono, stereo or rgbd (option sensor; default: all the recording has)")
      ->type_name("mono|stereo|rgbd")
      ->group(group);
}

void add_method_flags(CLI::App& command, SlamFlags& flags) {
  const char* group = "SLAM";
  command.add_option("--method", flags.method, "SLAM method, see below (default: auto; with --map: that of the map)")
      ->type_name("NAME")
      ->group(group);
  command.add_option("--map", flags.map, "With --continue: map file or run folder of orb, fusion or rtabmap")
      ->type_name("MAP")
      ->group(group);
  command
      .add_flag("--continue", flags.extend,
                "Continue the map of --map; the extended map is written to --out, another folder")
      ->group(group);
  add_sensor_flag(command, flags, group);
  command
      .add_option("--frontend", flags.frontend,
                  "Matching between frames: descriptors (orb) or optical flow (tracks) (option frontend; default: orb)")
      ->type_name("orb|tracks")
      ->group(group);
  command.add_option("--guess", flags.guess, "Initial guess of a scan's pose (option guess)")
      ->type_name("MODE")
      ->group(group);
  command.add_option("--loop-closing", flags.loop_closing, "Loop closing (option loop_closing; default: true)")
      ->type_name("true|false")
      ->group(group);
  add_run_flags(command, flags, group);
}

}  // namespace

void add_slam_flags(CLI::App& command, SlamFlags& flags) {
  add_method_flags(command, flags);
  add_output_flags(command, flags, "coverage>=95");
  add_view_flags(command, flags);
  add_live_flags(command, flags.live);
  add_record_flag(command, flags.live);
  add_data_flags(command, flags.data);
  command.footer(methods_text() + slam_footer);
}

void add_localize_flags(CLI::App& command, SlamFlags& flags) {
  command.add_option("--map", flags.map, "Map file or run folder")->type_name("MAP")->required()->group("Map");
  add_sensor_flag(command, flags, "Map");
  add_run_flags(command, flags, "Map");
  add_output_flags(command, flags, "recall>=95");
  add_view_flags(command, flags);
  add_live_flags(command, flags.live);
  add_record_flag(command, flags.live);
  add_data_flags(command, flags.data);
  command.footer(localize_footer);
}

std::optional<SE3> parse_initial_pose(const std::string& text, bool planar) {
  if (text.empty()) return std::nullopt;
  std::vector<double> numbers;
  for (const auto& piece : split(text, ',')) {
    const auto number = parse_finite(piece);
    if (!number) refuse_initial_pose(text, planar);
    numbers.push_back(*number);
  }
  if (numbers.size() != 3 && numbers.size() != 6) refuse_initial_pose(text, planar);
  if (planar && numbers.size() == 3) numbers = {numbers[0], numbers[1], 0.0, 0.0, 0.0, numbers[2]};
  numbers.resize(6, 0.0);
  constexpr double radians = std::numbers::pi / 180.0;
  const auto about = [&](const Eigen::Vector3d& axis, double degrees) { return SO3::exp(radians * degrees * axis); };
  const SO3 rotation = about(Eigen::Vector3d::UnitZ(), numbers[5]) * about(Eigen::Vector3d::UnitY(), numbers[4]) *
                       about(Eigen::Vector3d::UnitX(), numbers[3]);
  return SE3(rotation, {numbers[0], numbers[1], numbers[2]});
}

void apply_preset(const SlamFlags& flags, SlamMethod& method) {
  if (is_preset(flags.preset, fmt::format("the method '{}'", method.name()), method.presets()))
    method.set_preset(flags.preset);
}

void apply_settings(const SlamFlags& flags, const std::string& method, OptionTable& table) {
  apply_given_settings(flags, table);
  set_from_flag(table, "guess", flags.guess, "--guess", method);
  set_from_flag(table, "sensor", flags.sensor, "--sensor", method);
  set_from_flag(table, "frontend", flags.frontend, "--frontend", method);
  set_from_flag(table, "loop_closing", flags.loop_closing, "--loop-closing", method);
  // A method without a seed uses no random numbers: any seed gives its result.
  if (has_option(table, "seed")) apply_given_seed(flags, table);
}

}  // namespace rastro::cli
