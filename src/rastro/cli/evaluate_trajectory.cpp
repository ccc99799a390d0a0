// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/evaluate_trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/cli/trajectory_files.h"
#include "rastro/evaluate/trajectory_report.h"
#include "rastro/export/trajectory_curves.h"
#include "rastro/export/trajectory_plot.h"

namespace rastro::cli {
namespace {

constexpr const char* evaluate_trajectory_footer =
    R"(REF and EST are trajectory files in TUM (timestamp tx ty tz qx qy qz qw), KITTI (12 numbers a line) or EuRoC format
(timestamp,x,y,z,qw,qx,qy,qz,...), or run folders (their trajectory.txt); REF may also be a recording with ground truth. Format
and unit of the timestamps are detected; where a header names the columns, their order is that.
  matched     poses of REF and EST whose timestamps differ by at most --max-dt, nearest first, one to one. KITTI poses have the
              timestamps of FILE_times.txt or times.txt beside them; two KITTI files are matched line by line,
              unless they differ in length and both have timestamps
  coverage    % of the poses of REF within 0.6 steps of a matched pose; step: the longer median step of REF and EST (EST's at
              most 0.1 s). Of the ground truth of a EuRoC or TUM recording only the part between its first and last frame
              counts. Do not rank estimates of different coverage
  alignment   over all matched positions: none; se3: rotation and translation; sim3: and scale, for one camera; yaw: rotation
              about the z axis of REF and translation; origin: the first matched pose, for errors that grow from the start, as
              the curves of publications on odometry show them. Everything below is after alignment
  ATE         absolute trajectory error: distance of the positions, m
  RPE         relative pose error over each --rpe-delta: frames (f), seconds (s) or meters on EST (m), of consecutive pairs or
              of a pair from every pose (--rpe-pairs all)
  segments    KITTI's errors: from every tenth pose to the first one farther than each length along REF; % and deg/m
  drift       error of the motion from the first to the last matched pose per path length of REF between them
  covariances of a run folder with covariance_online.txt: share of the poses as first given whose error, from where the run began, is
              inside the ellipse that should hold 95 % of them, of positions and of rotations; NEES: mean normalized squared error
              for each degree of freedom, 1 is right; and by how much the sigmas would have to be larger to hold 95 %
A EuRoC reference is of the body. If ../cam0/sensor.yaml lies beside it, or --body-from-camera FILE is given, it is converted to
poses of the camera, and the output says so; --estimate-of body prevents this. KITTI raw is compared in the frame of its IMU.
Plots and CSV have rotations relative to the first pose of REF about the camera's axes (yaw: y, pitch: x, roll: z), or a body's (z, y, x).
--json prints an object for one EST, an array for several; its rpe_* are those of the first --rpe-delta.

Examples:
  rastro evaluate trajectory groundtruth.txt run --align sim3
  rastro evaluate trajectory 00_gt.txt orb.txt sptam.txt --plot compared.svg
  rastro evaluate trajectory 2011_09_26_drive_0014 classic hybrid --align origin --plot errors.svg --csv errors.csv
  rastro evaluate trajectory kitti_00 run --align sim3 --segments 10,20,30,40,50 --rpe-delta 10m
  rastro evaluate trajectory MH_01 run --align sim3 --json --require 'ate_rmse<=0.1' --require 'coverage>=95')";

struct EvaluateTrajectoryFlags {
  std::string reference;
  std::vector<std::string> estimates;
  TrajectoryFileFlags files;
  std::string align = "se3", rpe_pairs = "consecutive", plot, csv;
  std::vector<std::string> rpe_deltas, limits;
  std::vector<double> segments_m;
  double max_dt_s = 0.02;
  bool json = false, quiet = false;
};

TrajectoryScoreOptions score_options(const EvaluateTrajectoryFlags& flags) {
  TrajectoryScoreOptions options;
  options.alignment = parse_alignment(flags.align);
  if (!(flags.max_dt_s >= 0.0 && flags.max_dt_s <= 1e6))
    throw Error(fmt::format("{} is not a time difference", flags.max_dt_s), "--max-dt", "give seconds, such as 0.02");
  options.max_difference = from_seconds(flags.max_dt_s);
  if (flags.rpe_pairs != "consecutive" && flags.rpe_pairs != "all")
    throw Error(in_quotes(flags.rpe_pairs) + " is not a choice of pairs", "--rpe-pairs", "give consecutive or all");
  options.rpe_all_pairs = flags.rpe_pairs == "all";
  if (!flags.rpe_deltas.empty()) options.rpe_deltas.clear();
  for (const std::string& text : flags.rpe_deltas) options.rpe_deltas.push_back(parse_rpe_delta(text));
  if (!flags.segments_m.empty()) options.segments_m = flags.segments_m;
  for (const double length : options.segments_m)
    if (!(length > 0.0 && length < 1e9))
      throw Error(fmt::format("{} is not a length", length), "--segments", "give meters, such as 10,20,30,40,50");
  return options;
}

/// The file with its folder: run folders all hold a trajectory.txt.
std::string short_name(const std::string& file) {
  const std::filesystem::path path(file);
  return (path.parent_path().filename() / path.filename()).string();
}

TrajectoryPlot plot_of(const ReferenceTrajectory& reference, const std::vector<TrajectoryScores>& all) {
  TrajectoryPlot plot;
  const TrajectoryInput& input = reference.input;
  plot.title = fmt::format("{}, alignment {}", one_line(input.file), name_of(all.front().alignment));
  const bool by_frame = !input.has_stamps || all.front().pairing.by_index;
  plot.along_label = by_frame ? "frame" : "time [s]";
  for (std::size_t k = 0; k < input.poses.size(); ++k) {
    plot.along.push_back(by_frame ? static_cast<double>(k)
                                  : to_seconds(input.poses[k].stamp - input.poses.front().stamp));
    plot.reference.push_back(input.poses[k].world_from_body);
  }
  for (const TrajectoryScores& scores : all) {
    PlottedEstimate estimate;
    estimate.name = fmt::format("{} (ATE rmse {:.4f} m, coverage {:.1f} %)", short_name(scores.estimate),
                                scores.ate_m->rmse, scores.pairing.coverage_percent);
    for (const PosePair& pair : scores.pairs) estimate.reference_index.push_back(pair.reference);
    for (const StampedPose& pose : scores.aligned) estimate.poses.push_back(pose.world_from_body);
    plot.estimates.push_back(estimate);
  }
  plot.camera_axes = !reference.of_body;
  plot.y_is_down = reference.camera_world;
  return plot;
}

void write_curves(TrajectoryPlot plot, const std::vector<TrajectoryScores>& all, const std::string& file) {
  for (std::size_t k = 0; k < all.size(); ++k) plot.estimates[k].name = short_name(all[k].estimate);
  write_whole_file(file, trajectory_curves_as_csv(plot));
}

int missed_limits(const TrajectoryScores& scores, const std::vector<ScoreLimit>& limits) {
  int code = done;
  for (const ScoreLimit& limit : limits) {
    const auto value = trajectory_score_named(scores, limit.name);
    if (keeps_limit(value, limit)) continue;
    fmt::print(stderr, "rastro: --require {}{}{} missed by {}: it is {}\n", limit.name,
               limit.at_least ? ">=" : "<=", limit.value, one_line(scores.estimate),
               value ? fmt::format("{:.6g}", *value) : "n/a");
    code = limit_missed;
  }
  return code;
}

void print_text(const ReferenceTrajectory& reference, const std::vector<TrajectoryInput>& estimates,
                const std::vector<TrajectoryScores>& all) {
  fmt::print("reference   {}\n", one_line(describe(reference.input), 500));
  fmt::print("poses       {}\n", one_line(reference.frames, 500));
  for (std::size_t k = 0; k < all.size(); ++k)
    fmt::print("\nestimate    {}\n{}", one_line(describe(estimates[k]), 500), trajectory_scores_as_text(all[k]));
  if (all.size() > 1) fmt::print("\n{}", trajectory_scores_as_table(all));
}

void require_use_of_times(const EvaluateTrajectoryFlags& flags, const ReferenceTrajectory& reference,
                          const std::vector<TrajectoryInput>& estimates) {
  const auto takes_times = [](const TrajectoryInput& input) {
    return input.format == TrajectoryFormat::kitti && !input.of_recording;
  };
  if (flags.files.times.empty() || takes_times(reference.input)) return;
  if (std::any_of(estimates.begin(), estimates.end(), takes_times)) return;
  throw Error("is unused: no KITTI poses are given, and the others have timestamps", "--times", "omit it");
}

void warn_of_few(const TrajectoryScores& scores) {
  constexpr std::size_t least = 3;
  if (scores.alignment == TrajectoryAlignment::none || scores.pairs.size() >= least) return;
  log_warning(fmt::format("{}: {} matched: an alignment makes the error of so few small, whatever they are",
                          one_line(scores.estimate), scores.pairs.size() == 1 ? "1 pose is" : "2 poses are"));
}

std::string first_line(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line;
  return std::getline(stream, line) ? line : std::string();
}

/// Of a file that rastro wrote for one camera, which says so in its first line. What is written while a run goes on
/// cannot know yet; trajectory.txt beside it does.
bool is_up_to_scale(const std::filesystem::path& file) {
  std::string line = first_line(file);
  if (line.find("if result.json says so") != std::string::npos)
    line = first_line(file.parent_path() / "trajectory.txt");
  return line.starts_with('#') && line.find("arbitrary units") != std::string::npos;
}

void warn_of_arbitrary_units(const TrajectoryScores& scores, const TrajectoryInput& estimate) {
  if (scores.alignment == TrajectoryAlignment::sim3 || !is_up_to_scale(estimate.file)) return;
  log_warning(
      fmt::format("{} is of one camera, in arbitrary units: its errors in meters say nothing without --align "
                  "sim3, or 'rastro scale' before",
                  one_line(estimate.file)));
}

void warn_of_other_length(const TrajectoryInput& reference, const TrajectoryInput& estimate,
                          const TrajectoryScores& scores) {
  if (!scores.pairing.by_index || reference.poses.size() == estimate.poses.size()) return;
  log_warning(
      fmt::format("{} has {} poses and {} {}: they are matched line by line from the first, which is right only "
                  "if both begin with the same frame and skip none; KITTI's times.txt beside both tells",
                  one_line(estimate.file), estimate.poses.size(), one_line(reference.file), reference.poses.size()));
}

int evaluate_trajectory(const EvaluateTrajectoryFlags& flags) {
  const TrajectoryScoreOptions options = score_options(flags);
  std::vector<ScoreLimit> limits;
  for (const std::string& text : flags.limits) limits.push_back(parse_trajectory_limit(text));
  if (!flags.plot.empty()) require_plot_name(flags.plot);
  const ReferenceTrajectory reference = read_reference(flags.reference, flags.files);
  std::vector<TrajectoryInput> estimates;
  std::vector<TrajectoryScores> all;
  for (const std::string& path : flags.estimates) {
    estimates.push_back(read_estimate(path, reference, flags.files));
    all.push_back(score_trajectory(reference.input, estimates.back(), options));
    warn_of_other_length(reference.input, estimates.back(), all.back());
    all.back().frames = reference.frames;
    all.back().consistency =
        consistency_of_run(path, reference, estimates.back(), all.back().scale(), options.max_difference);
  }
  require_use_of_times(flags, reference, estimates);
  for (std::size_t k = 0; k < all.size(); ++k) {
    warn_of_few(all[k]);
    warn_of_arbitrary_units(all[k], estimates[k]);
  }
  if (!flags.plot.empty()) write_trajectory_plot(plot_of(reference, all), flags.plot);
  if (!flags.csv.empty()) write_curves(plot_of(reference, all), all, flags.csv);
  if (flags.json)
    fmt::print("{}", trajectory_scores_as_json(all));
  else if (!flags.quiet)
    print_text(reference, estimates, all);
  int code = done;
  for (const TrajectoryScores& scores : all) code = std::max(code, missed_limits(scores, limits));
  return code;
}

void add_input_flags(CLI::App& command, EvaluateTrajectoryFlags& flags) {
  command.add_option("REF", flags.reference, "Reference: trajectory file, run folder or recording with ground truth")
      ->type_name("")
      ->required();
  command.add_option("EST", flags.estimates, "Estimates: trajectory files or run folders")->type_name("")->required();
  command
      .add_option("--max-dt", flags.max_dt_s,
                  "Maximum timestamp difference of matched poses in seconds (default: 0.02)")
      ->type_name("S");
  command.add_option("--times", flags.files.times, "Timestamps of KITTI poses (default: FILE_times.txt or times.txt)")
      ->type_name("FILE");
  command.add_option("--frames", flags.files.frames, "Frames A to B-1 of the recording of REF only (default: all)")
      ->type_name("A:B");
  command
      .add_option("--estimate-of", flags.files.estimate_of,
                  "What the poses of EST are of (default: camera, if REF is of the body and T_BS is known)")
      ->type_name("camera|body");
  command
      .add_option("--body-from-camera", flags.files.body_from_camera,
                  "Calibration with T_BS, if REF is of the body and EST of the camera")
      ->type_name("FILE");
}

void add_score_flags(CLI::App& command, EvaluateTrajectoryFlags& flags) {
  command.add_option("--align", flags.align, "Alignment of EST with REF (default: se3)")
      ->type_name("none|se3|sim3|yaw|origin");
  command.add_option("--rpe-delta", flags.rpe_deltas, "RPE deltas, such as 10m (default: 1f,1s,1m)")
      ->type_name("LIST")
      ->delimiter(',')
      ->allow_extra_args(false);
  command.add_option("--rpe-pairs", flags.rpe_pairs, "Pairs of the RPE (default: consecutive)")
      ->type_name("consecutive|all");
  command
      .add_option("--segments", flags.segments_m, "Lengths of the KITTI segments in meters (default: 100,200,...,800)")
      ->type_name("LIST")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      .add_option(
          "--require", flags.limits,
          "Limit for every EST, such as 'ate_rmse<=0.3' or 'coverage>=95'; exit code 1 if missed; may be repeated")
      ->type_name("LIMIT")
      ->allow_extra_args(false);
  command.add_option("--plot", flags.plot, "Plot positions, rotations, errors and the path (.svg or .png)")
      ->type_name("FILE");
  command.add_option("--csv", flags.csv, "Write positions, rotations and their errors of every matched pose as CSV")
      ->type_name("FILE");
  command.add_flag("--json", flags.json, "Print the result as JSON");
  command.add_flag("--quiet", flags.quiet, "Print errors and warnings only");
}

}  // namespace

void add_evaluate_trajectory_command(CLI::App& evaluate, Context& context) {
  CLI::App* command =
      evaluate.add_subcommand("trajectory", "ATE, RPE, KITTI segment errors, coverage and drift against a reference");
  const auto flags = std::make_shared<EvaluateTrajectoryFlags>();
  add_input_flags(*command, *flags);
  add_score_flags(*command, *flags);
  command->footer(evaluate_trajectory_footer);
  command->callback([flags, &context] {
    if (flags->quiet) set_log_sink({});
    context.exit_code = evaluate_trajectory(*flags);
  });
}

}  // namespace rastro::cli
