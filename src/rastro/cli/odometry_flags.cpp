// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/odometry_flags.h"

#include <fmt/format.h>

#include "rastro/cli/method_text.h"
#include "rastro/methods/methods.h"

namespace rastro::cli {
namespace {

constexpr const char* footer = R"(
Writes into --out:
  trajectory.txt         final pose of every frame: stamp tx ty tz qx qy qz qw, world_from_camera; world: the first camera
  trajectory_online.txt  each pose as first given
  stats.csv    state, reason, matches, inliers, times per frame   events.jsonl  each change of state, with its reason
  options.yaml all values in force    about.json  version, machine, input    result.json  coverage, states, times, hash
One camera without depth does not know lengths: they are relative unless --scale gives a source, and every output says
which.

Examples:
  rastro odometry kitti/00 --out run
  rastro odometry kitti/00 --out run --scale camera-height=1.65
  rastro odometry rgbd_dataset_freiburg1_desk --out run --method rgbd
  rastro odometry MH_01_easy --out run --scale reference=truth.txt --set features=600
  rastro odometry kitti/00 --out run --method profiles --calibrate-yaw --reference kitti/poses/00.txt
  rastro evaluate trajectory kitti/poses/00.txt run --align sim3)";

}  // namespace

void add_odometry_flags(CLI::App& command, OdometryFlags& flags) {
  add_data_flags(command, flags.data);
  const char* group = "Odometry";
  command
      .add_option("--method", flags.method,
                  fmt::format("{}; see below (default: {})", names_text(odometry_methods()), flags.method))
      ->group(group);
  command
      .add_option("--matcher", flags.matcher,
                  "What features are matched by (option matcher of features; default: tracks)")
      ->group(group);
  command.add_flag("--refine", flags.refine, "Adjust the last keyframes together (the default of features)")
      ->group(group);
  command.add_flag("--no-refine", flags.no_refine, "Do not")->group(group);
  command
      .add_option("--scale", flags.scale,
                  "Where metres come from: camera-height=METRES (above a flat road) or reference=FILE (a trajectory)")
      ->type_name("SOURCE")
      ->group(group);
  command
      .add_flag("--calibrate-yaw", flags.calibrate_yaw,
                "With --reference and a method with the option lambda, such as profiles: print the radians of a "
                "pixel's shift that suit it best")
      ->group(group);
  command.add_option("--reference", flags.reference, "Trajectory of the camera, for --calibrate-yaw")
      ->type_name("FILE")
      ->group(group);
  add_settings_flags(command, flags, group, "rastro options METHOD");
  add_folder_flags(command, flags);
  command.footer("Methods:\n" + methods_text(odometry_methods()) + footer);
}

void apply_settings(const OdometryFlags& flags, OptionTable& table) {
  apply_given_settings(flags, table);
  if (!flags.matcher.empty()) table.set("matcher", flags.matcher, "--matcher");
  if (flags.refine) table.set("refine", "true", "--refine");
  if (flags.no_refine) table.set("refine", "false", "--no-refine");
  apply_given_seed(flags, table);
}

}  // namespace rastro::cli
