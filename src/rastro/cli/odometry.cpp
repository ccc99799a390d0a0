// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <memory>
#include <tuple>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/hash.h"
#include "rastro/base/log.h"
#include "rastro/base/task_pool.h"
#include "rastro/base/text.h"
#include "rastro/cli/command.h"
#include "rastro/cli/interrupt.h"
#include "rastro/cli/live_flags.h"
#include "rastro/cli/live_odometry.h"
#include "rastro/cli/loss_advice.h"
#include "rastro/cli/mcap_sink.h"
#include "rastro/cli/odometry_flags.h"
#include "rastro/cli/program.h"
#include "rastro/cli/progress_bar.h"
#include "rastro/cli/yaw_calibration.h"
#include "rastro/dataset/live/live.h"
#include "rastro/dataset/open.h"
#include "rastro/dataset/recording.h"
#include "rastro/methods/method_choice.h"
#include "rastro/methods/methods.h"
#include "rastro/odometry/ground_scale.h"
#include "rastro/odometry/scale.h"
#include "rastro/sensor/trajectory_file.h"
#include "rastro/session/odometry_run.h"
#include "rastro/session/trajectory_text.h"

namespace rastro::cli {
namespace {

/// Makes the trajectory metric; without a reference or height it stays up to scale.
struct ScaleSource {
  std::string said = "relative";
  Trajectory reference;
  double camera_height_m = 0.0;
};

ScaleSource scale_source(const std::string& text) {
  constexpr std::string_view reference = "reference=", height = "camera-height=";
  ScaleSource source;
  if (text.empty()) return source;
  source.said = "meters, from " + text;
  if (text.starts_with(reference)) {
    source.reference = read_trajectory(text.substr(reference.size()));
    return source;
  }
  const auto meters = text.starts_with(height) ? parse_finite(text.substr(height.size())) : std::nullopt;
  if (!meters || *meters <= 0.0) {
    throw Error(fmt::format("'{}' is not a source of scale", text), "--scale",
                "give camera-height=METERS, such as camera-height=1.65, or reference=FILE");
  }
  source.camera_height_m = *meters;
  return source;
}

/// Everything that can be wrong with flags and input is found here, before a folder is made.
struct Prepared {
  std::unique_ptr<OdometryMethod> method;
  std::string choice;  ///< Why this one; empty: it was asked for by name.
  OptionTable table;   ///< Points into the method.
  ScaleSource scale;
  RunInput input;
  std::optional<std::int64_t> frames;
  std::unique_ptr<TaskPool> pool;
  std::unique_ptr<Odometry> odometry;
  std::optional<GroundScale> ground;
  Trajectory yaw_reference;
};

ScaleSource scale_source(const OdometryFlags& flags, const OdometryMethod& method) {
  if (!method.is_metric()) return scale_source(flags.scale);
  if (!flags.scale.empty())
    throw Error("is for methods without metric scale", "--scale", "omit it: the trajectory of this method is metric");
  ScaleSource source;
  source.said = method.wants_depth() ? "meters, from depth" : "meters";
  return source;
}

/// Option lambda: radians per pixel of shift, 0: from the focal length; nullopt where the method has no such option.
std::optional<double> lambda_of(const OptionTable& table) {
  for (std::size_t i = 0; i < table.options().size(); ++i)
    if (table.options()[i].name == "lambda") return parse_finite(table.value_of(i));
  return std::nullopt;
}

Trajectory yaw_reference(const OdometryFlags& flags, const OptionTable& table) {
  if (!flags.calibrate_yaw) return {};
  if (!lambda_of(table) || flags.reference.empty()) {
    throw Error("needs profiles and a reference", "--calibrate-yaw", "add --method profiles --reference FILE");
  }
  return read_trajectory(flags.reference);
}

/// The method by its name, or of `auto` as the sensors of the recording have it, and why.
std::pair<std::unique_ptr<OdometryMethod>, std::string> method_for(const OdometryFlags& flags) {
  if (flags.method != "auto") return {odometry_method(flags.method), ""};
  if (is_live(flags.data.path))
    throw Error("cannot look at a live source beforehand", "--method auto", "give --method features or rgbd");
  OpenOptions open = open_options(flags.data);
  open.want_depth = true;
  const MethodChoice choice = odometry_choice(rastro::open(flags.data.path, open)->info());
  log_info(fmt::format("method {}: {}", choice.method, choice.reason));
  return {odometry_method(choice.method), choice.reason};
}

std::unique_ptr<Prepared> prepare(const OdometryFlags& flags) {
  auto run = std::make_unique<Prepared>();
  std::tie(run->method, run->choice) = method_for(flags);
  run->table = run->method->options();
  if (is_preset(flags.preset, fmt::format("the method '{}'", run->method->name()), run->method->presets()))
    run->method->set_preset(flags.preset);
  apply_settings(flags, run->table);
  run->yaw_reference = yaw_reference(flags, run->table);
  run->scale = scale_source(flags, *run->method);
  OpenOptions open = open_options(flags.data);
  open.want_depth = run->method->wants_depth();
  open.want_right = run->method->wants_right();
  run->input = open_run_input(flags, open);
  const SourceInfo& info = run->input.source->info();
  if (info.frame_count >= 0) run->frames = FrameChoice(open, info.frame_count, info.path).count;
  run->pool = std::make_unique<TaskPool>(flags.data.threads);
  run->odometry = run->method->make(info, {.pool = run->pool.get()});
  if (run->scale.camera_height_m > 0.0) run->ground.emplace(calibrated_camera(info), run->scale.camera_height_m);
  return run;
}

std::string poses_text(const Trajectory& trajectory, const std::string& scale) {
  return trajectory_text(trajectory,
                         fmt::format("world_from_camera of every frame; world: the first camera; scale: {}", scale));
}

void apply_scale(const Prepared& prepared, OdometryRunEnd& end) {
  const ScaleSource& source = prepared.scale;
  end.result.scale = source.said;
  if (source.reference.empty() && !prepared.ground) return;
  std::optional<double> factor;
  if (prepared.ground) {
    if (const auto found = prepared.ground->find()) {
      factor = found->meters_per_unit;
      end.result.scale +=
          fmt::format(" ({} pairs of frames, +- {:.1f} %)", found->frames, 100.0 * found->relative_sigma);
    }
  } else {
    factor = scale_from_reference(end.trajectory, source.reference);
  }
  if (factor) {
    scale_trajectory(end.trajectory, *factor);
    return;
  }
  end.result.scale = "relative";
  log_warning(prepared.ground
                  ? "the road was not observed well enough to estimate the scale; the trajectory stays up to scale"
                  : "too few poses match the reference to estimate the scale; the trajectory stays up to scale");
}

std::string summary(const OdometryRunEnd& end, const std::string& folder) {
  const OdometryResult& result = end.result;
  std::string text = fmt::format("{}: {} frames, {} tracked", result.method.name, result.frames, result.tracking);
  if (result.initializing > 0)
    text += fmt::format(", {} before initialization ({})", result.initializing,
                        end.trajectory.empty() ? "it never came" : "poses added afterwards");
  if (result.weak + result.lost > 0) text += fmt::format(", {} weak, {} lost", result.weak, result.lost);
  if (!result.method.choice.empty()) text += "\nmethod chosen: " + result.method.choice;
  text += fmt::format("\npath {:.2f} (scale: {}); {:.1f} ms per frame, {:.0f} MB\n", result.path_length, result.scale,
                      result.ms_per_frame_mean, result.peak_memory_mb);
  if (result.live) text += "live: " + summary_of(*result.live) + "\n";
  if (!result.reasons.empty()) {
    text += "reasons:";
    for (const auto& [reason, count] : result.reasons) text += fmt::format(" {} {}", reason, count);
    text += "  (details in events.jsonl)\n";
  }
  if (result.reasons.contains(name_of(OdometryReason::calibration_doubtful))) {
    text +=
        "the images contradict the calibration: check fx, fy, cx, cy and the distortion (--calibration, --intrinsics); "
        "events.jsonl has the values that fit better\n";
  }
  for (const InputWarning& warning : result.warnings) text += "warning: " + warning.text + "\n";
  if (result.skipped_frames > 0) text += fmt::format("{} frames could not be read\n", result.skipped_frames);
  const auto dark = result.reasons.find(name_of(OdometryReason::dark_or_blank));
  if (dark != result.reasons.end() && dark->second == result.frames)
    text += advice_for(OdometryReason::dark_or_blank) + "\n";
  else if (result.tracking == 0)
    text +=
        "no motion was found: was the camera at rest, or is the calibration wrong? 'rastro check' checks the "
        "recording\n";
  return text + fmt::format("poses written to {}/trajectory.txt\n", folder);
}

/// Null without --view.
std::unique_ptr<LiveOdometry> live_view(const OdometryFlags& flags, const Prepared& prepared) {
  const auto hello = live_hello(flags, prepared.method->name(), prepared.frames);
  return hello ? std::make_unique<LiveOdometry>(flags.server, *hello, *prepared.odometry) : nullptr;
}

OdometryRun wired(Prepared& prepared, RunFolder& folder, ProgressBar& bar, LiveOdometry* live, McapSink* mcap) {
  OdometryRun run;
  run.source = prepared.input.source.get();
  run.live = prepared.input.live;
  run.method = prepared.odometry.get();
  run.folder = &folder;
  run.stop = &catch_interrupts();
  run.frames_asked = prepared.frames;
  run.watch = [&prepared, live, mcap](const Frame& frame, const OdometryUpdate& update) {
    if (prepared.ground && update.state == OdometryState::tracking) {
      prepared.ground->add(frame.image, update.world_from_camera);
    }
    if (mcap != nullptr) mcap->add(frame, update);
    if (live != nullptr) live->show(frame, update);
  };
  run.progress = [&bar](const OdometryProgress& progress) { bar.show(progress); };
  return run;
}

void run_odometry(const OdometryFlags& flags) {
  if (flags.data.quiet) set_log_sink({});
  const std::unique_ptr<Prepared> prepared = prepare(flags);
  const std::unique_ptr<LiveOdometry> live = live_view(flags, *prepared);
  for (const std::string& warning : prepared->input.source->info().warnings) log_warning(warning);
  RunFolder folder(flags.out, flags.force);
  folder.write_about(prepared->input.source->info(), command_line());
  folder.write_options(prepared->table);
  watch_while_idle(prepared->input, live.get());
  ProgressBar bar(!flags.data.quiet);
  const auto mcap = mcap_sink(flags.mcap, flags.out, prepared->method->name(), prepared->input.source->info());
  OdometryRunEnd end = odometry_run(wired(*prepared, folder, bar, live.get(), mcap.get()));
  bar.clear();
  end.result.method = {prepared->method->name(), prepared->choice};
  finish_recording(prepared->input, end.result.live);
  apply_scale(*prepared, end);
  end.result.path_length = path_length(end.trajectory);
  const std::string text = poses_text(end.trajectory, end.result.scale);
  Sha256 hash;
  hash.add(text);
  end.result.result_sha256 = hash.finish();
  if (end.result.frames == 0 && !end.result.interrupted) {
    folder.discard();
    if (end.failure) std::rethrow_exception(end.failure);
    throw Error(end.first_skip.empty() ? "has no frames" : "no frame could be read; the first: " + end.first_skip,
                flags.data.path, "'rastro check' lists what is wrong");
  }
  write_whole_file(folder.file("trajectory.txt"), text);
  folder.write_result(to_json(end.result));
  if (mcap) mcap->finish(end, *prepared->pool);
  if (end.failure) std::rethrow_exception(end.failure);
  if (flags.calibrate_yaw) {
    const double lambda = lambda_of(prepared->table).value_or(0.0);
    const double in_force = lambda > 0.0 ? lambda : 1.0 / calibrated_camera(prepared->input.source->info()).fx;
    fmt::print("{}", yaw_calibration_report(end.trajectory, prepared->yaw_reference, in_force));
  } else if (flags.data.json) {
    fmt::print("{}", to_json(end.result));
  } else if (!flags.data.quiet) {
    fmt::print("{}", summary(end, flags.out));
  }
  if (live) {
    live->finish(end);
    live->wait_until_closed();
  }
}

}  // namespace

void add_odometry_command(CLI::App& app, Context&) {
  CLI::App* command = app.add_subcommand("odometry", "Estimates the trajectory of a single calibrated camera");
  const auto flags = std::make_shared<OdometryFlags>();
  add_odometry_flags(*command, *flags);
  command->callback([command, flags] {
    const CLI::Option* seed = command->get_option_no_throw("--seed");
    flags->seed_given = seed != nullptr && seed->count() > 0;
    run_odometry(*flags);
  });
}

}  // namespace rastro::cli
