// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/odometry_flags.h"

#include <fmt/format.h>

#include "rastro/cli/live_flags.h"
#include "rastro/cli/method_text.h"
#include "rastro/methods/methods.h"

namespace rastro::cli {
namespace {

constexpr const char* odometry_footer = R"(
Output files, in --out:
  trajectory.txt         final pose of every frame, TUM format: timestamp tx ty tz qx qy qz qw, world_from_camera; the
                         world is the first camera
  trajectory_online.txt  pose of every frame as first estimated
  stats.csv              state, reason, matches, inliers, times per frame
  events.jsonl           changes of state with reasons
  options.yaml           options in use
  about.json             version, machine, input, command line
  result.json            coverage (% of the requested frames with a pose), states, scale, times, hash of the result
With one camera and without depth the trajectory is up to scale unless --scale is given; trajectory.txt and result.json
say which.

Examples:
  rastro odometry kitti/00 --out run
  rastro odometry kitti/00 --out run --view             in a browser, while it runs
  rastro odometry kitti/00 --out run --scale camera-height=1.65
  rastro odometry rgbd_dataset_freiburg1_desk --out run --method rgbd
  rastro odometry MH_01_easy --out run --scale reference=groundtruth.txt --set features=600
  rastro odometry kitti/00 --out run --method classic --preset paper
  rastro odometry kitti/00 --out run --method profiles --calibrate-yaw --reference kitti/poses/00.txt
  rastro evaluate trajectory kitti/poses/00.txt run --align sim3)";

}  // namespace

void add_odometry_flags(CLI::App& command, OdometryFlags& flags) {
  const char* group = "Odometry";
  command
      .add_option("--method", flags.method,
                  fmt::format("{}, or auto: by the sensors; see below (default: {})", names_text(odometry_methods()),
                              flags.method))
      ->type_name("NAME")
      ->group(group);
  command
      .add_option(
          "--matcher", flags.matcher,
          "Feature matching: tracks, sift, orb or surf; of features (default: tracks) and classic (surf, sift or orb; "
          "default: surf)")
      ->type_name("MODE")
      ->group(group);
  command.add_flag("--refine", flags.refine, "Local bundle adjustment of the last keyframes (default of features)")
      ->group(group);
  command.add_flag("--no-refine", flags.no_refine, "No local bundle adjustment")->group(group);
  command
      .add_option(
          "--scale", flags.scale,
          "Makes the trajectory metric: camera-height=METERS (above a flat road) or reference=FILE (a trajectory)")
      ->type_name("SOURCE")
      ->group(group);
  command
      .add_flag("--calibrate-yaw", flags.calibrate_yaw,
                "With --method profiles and --reference: print the option lambda (rad/px) that fits the reference best")
      ->group(group);
  command.add_option("--reference", flags.reference, "Reference trajectory of the camera, for --calibrate-yaw")
      ->type_name("FILE")
      ->group(group);
  add_preset_flag(command, flags, group, "classic, profiles, hybrid: the positioning paper's own steps");
  add_settings_flags(command, flags, group, "rastro options METHOD");
  add_disturbance_flag(command, flags);
  add_folder_flags(command, flags);
  add_mcap_flag(command, flags);
  add_live_flags(command, flags.live);
  add_record_flag(command, flags.live);
  add_view_flags(command, flags);
  add_data_flags(command, flags.data);
  command.footer("Methods:\n" + methods_text(odometry_methods()) + odometry_footer);
}

void apply_settings(const OdometryFlags& flags, OptionTable& table) {
  apply_given_settings(flags, table);
  if (!flags.matcher.empty()) table.set("matcher", flags.matcher, "--matcher");
  if (flags.refine) table.set("refine", "true", "--refine");
  if (flags.no_refine) table.set("refine", "false", "--no-refine");
  apply_given_seed(flags, table);
}

}  // namespace rastro::cli
