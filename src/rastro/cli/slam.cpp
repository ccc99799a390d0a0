// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/task_pool.h"
#include "rastro/base/text.h"
#include "rastro/cli/command.h"
#include "rastro/cli/interrupt.h"
#include "rastro/cli/limits.h"
#include "rastro/cli/live_flags.h"
#include "rastro/cli/live_slam.h"
#include "rastro/cli/map_path.h"
#include "rastro/cli/masks.h"
#include "rastro/cli/mcap_sink.h"
#include "rastro/cli/program.h"
#include "rastro/cli/progress_bar.h"
#include "rastro/cli/size_text.h"
#include "rastro/cli/slam.h"
#include "rastro/cli/slam_flags.h"
#include "rastro/cli/slam_outputs.h"
#include "rastro/dataset/open.h"
#include "rastro/dataset/recording.h"
#include "rastro/map/file/growing_map_file.h"
#include "rastro/map/file/map_file.h"
#include "rastro/methods/method_choice.h"
#include "rastro/methods/methods.h"
#include "rastro/session/slam_run.h"

namespace rastro::cli {
namespace {

/// Everything that can be wrong with flags and input is found here, before a folder is made.
struct Prepared {
  std::unique_ptr<SlamMethod> method;
  OptionTable table;  ///< Points into the method.
  std::vector<ScoreLimit> limits;
  RunInput input;
  std::optional<std::int64_t> frames;
  std::optional<Masks> masks;
  std::unique_ptr<TaskPool> pool;
  std::unique_ptr<GrowingMapFile> map_file;  ///< Null: no map is made.
  SlamContext context;
  std::unique_ptr<Slam> slam;
};

void load_map_of(const SlamFlags& flags, SlamContext& context) {
  if (flags.map.empty()) {
    if (flags.extend) throw Error("needs a map", "--continue", "give --map MAP");
    return;
  }
  const std::filesystem::path file = map_file_of(flags.map);
  std::error_code ignored;
  // Absolute: a bare map.rastro has no parent to compare. The file itself: it may be a link from elsewhere.
  const std::filesystem::path folder = std::filesystem::absolute(file, ignored).parent_path(), out = flags.out;
  if (std::filesystem::equivalent(folder, out, ignored) ||
      std::filesystem::equivalent(file, out / "map.rastro", ignored))
    throw Error("holds the map, which would be overwritten", flags.out, "give another folder with --out");
  context.map = load_map(file);
  context.extend_map = flags.extend;
}

SlamContext context_of(const SlamFlags& flags) {
  SlamContext context;
  const std::vector<std::string> modes = {"step", "pipelined"};
  if (std::find(modes.begin(), modes.end(), flags.mode) == modes.end()) {
    throw Error(in_quotes(flags.mode) + " is not a mode", "--mode", did_you_mean(flags.mode, modes));
  }
  context.pipelined = flags.mode == "pipelined";
  if (!flags.max_memory.empty()) context.max_memory_bytes = parse_size(flags.max_memory, "--max-memory");
  load_map_of(flags, context);
  context.stop = &catch_interrupts();
  return context;
}

/// "orb, rtabmap, fusion".
std::string methods_that(bool (SlamMethod::*can)() const) {
  std::string names;
  for (const auto& method : slam_methods())
    if ((method.get()->*can)()) names += (names.empty() ? "" : ", ") + method->name();
  return names;
}

std::unique_ptr<SlamMethod> method_for(const SlamFlags& flags, const SlamContext& context) {
  if (!context.map) return slam_method(flags.method.empty() ? "auto" : flags.method);
  const std::string& maker = context.map->method;
  auto method = slam_method(maker);
  if (!flags.method.empty() && flags.method != maker)
    throw Error(fmt::format("the map was made by '{}'", one_line(maker)), "--method", "omit --method");
  if (flags.extend && !method->can_extend())
    throw Error(fmt::format("the method '{}' cannot continue a map", method->name()), flags.map,
                "give a map made by 'rastro slam DATA --method NAME' with " + methods_that(&SlamMethod::can_extend));
  if (!method->can_localize())
    throw Error(fmt::format("the method '{}' cannot localize in a map", method->name()), flags.map,
                "give a map made by 'rastro slam DATA --method NAME' with " + methods_that(&SlamMethod::can_localize));
  if (!context.extend_map && context.map->keyframes.empty())
    throw Error("has no keyframes: nothing can be found in it", flags.map, "map the place first");
  return method;
}

/// Of `auto`, the method that it will choose: no choice by texture is between planar ones and others.
bool is_planar(const SlamMethod& method, const SourceInfo& source) {
  if (method.name() != "auto") return method.is_planar();
  return slam_method(slam_choices(source, 1.0, 0.0).front().method)->is_planar();
}

SlamTask task_of(const SlamContext& context) {
  return context.map && !context.extend_map ? SlamTask::localize : SlamTask::map;
}

/// A map can be used with another camera, but a wrong calibration of the same one would bend all poses.
void warn_of_other_camera(const Map& map, const SourceInfo& info) {
  constexpr double most_difference = 0.02;
  if (map.cameras.empty() || map.cameras.front().kind == CameraKind::stereo) return;  // rectified
  if (info.cameras.empty() || !info.cameras.front().camera) return;
  const Camera &of_map = map.cameras.front().intrinsics, &of_run = *info.cameras.front().camera;
  if (of_map.width != of_run.width || std::abs(of_run.fx / of_map.fx - 1.0) < most_difference) return;
  log_warning(
      fmt::format("--map: was made with a focal length of {:.1f} px, this run has {:.1f} px: right for another camera, "
                  "wrong for the "
                  "same one",
                  of_map.fx, of_run.fx));
}

Prepared prepare(const SlamFlags& flags, StepsShown on_finishing) {
  Prepared run;
  run.context = context_of(flags);
  run.context.on_finishing = std::move(on_finishing);
  run.method = method_for(flags, run.context);
  run.table = run.method->options();
  apply_preset(flags, *run.method);
  apply_settings(flags, run.method->name(), run.table);
  run.limits = parse_limits(flags.limits, limit_numbers_of(SlamResult{}), "'coverage>=95'");
  OpenOptions open = open_options(flags.data);
  open.want_color = run.method->wants_color();
  open.want_depth = run.method->wants_depth();
  open.want_right = run.method->wants_right();
  run.input = open_run_input(flags, open);
  run.context.live = run.input.live != nullptr;
  const SourceInfo& info = run.input.source->info();
  if (info.frame_count >= 0) run.frames = FrameChoice(open, info.frame_count, info.path).count;
  if (run.context.map) warn_of_other_camera(*run.context.map, info);
  if (!flags.mask.empty()) run.masks.emplace(flags.mask);
  run.pool = std::make_unique<TaskPool>(flags.data.threads);
  run.context.pool = run.pool.get();
  if (task_of(run.context) == SlamTask::map)
    run.map_file = std::make_unique<GrowingMapFile>(std::filesystem::path(flags.out) / "map.rastro", info.path);
  run.context.archive = run.map_file.get();
  run.context.initial_pose = parse_initial_pose(flags.initial_pose, is_planar(*run.method, info));
  run.slam = run.method->make(info, run.context);
  return run;
}

/// Null without --view.
std::unique_ptr<LiveSlam> live_view(const SlamFlags& flags, Prepared& prepared) {
  const auto hello = live_hello(flags, prepared.method->name(), prepared.frames);
  if (!hello) return nullptr;
  const bool maps = task_of(prepared.context) == SlamTask::map;
  return std::make_unique<LiveSlam>(flags.server, *hello, *prepared.slam, maps, flags.out,
                                    prepared.context.max_memory_bytes);
}

SlamRun wired(Prepared& prepared, RunFolder& folder, ProgressBar& bar, LiveSlam* live, McapSink* mcap) {
  SlamRun run;
  run.source = prepared.input.source.get();
  run.live = prepared.input.live;
  run.method = prepared.slam.get();
  run.folder = &folder;
  run.stop = &catch_interrupts();
  run.frames_asked = prepared.frames;
  run.progress = [&bar, live, mcap](const SlamProgress& progress) {
    bar.show(progress);
    if (mcap != nullptr) mcap->add(*progress.frame, *progress.last);
    if (live != nullptr) live->show(progress);
  };
  if (prepared.masks) run.mask_of = [&prepared](const Frame& frame) { return prepared.masks->mask_of(frame); };
  run.map_file = prepared.map_file.get();
  run.initial_pose = prepared.context.initial_pose.value_or(SE3());
  run.max_memory_bytes = prepared.context.max_memory_bytes;
  return run;
}

[[noreturn]] void refuse_without_frames(const SlamRunEnd& end, const RunFolder& folder, const std::string& path) {
  folder.discard();
  if (end.failure) std::rethrow_exception(end.failure);
  throw Error(end.first_skip.empty() ? "has no frames" : "no frame could be read; the first: " + end.first_skip, path,
              "'rastro check' lists what is wrong");
}

}  // namespace

int run_slam(const SlamFlags& flags) {
  if (flags.data.quiet) set_log_sink({});
  std::optional<ProgressBar> shown;
  Prepared prepared = prepare(flags, [&shown](const std::string& what, std::size_t done, std::size_t all) {
    if (shown) shown->show_steps(what, done, all);
  });
  const std::unique_ptr<LiveSlam> live = live_view(flags, prepared);
  for (const std::string& warning : prepared.input.source->info().warnings) log_warning(warning);
  RunFolder folder(flags.out, flags.force);
  folder.write_about(prepared.input.source->info(), command_line());
  folder.write_options(prepared.table);
  watch_while_idle(prepared.input, live.get());
  ProgressBar& bar = shown.emplace(!flags.data.quiet);
  const auto mcap = mcap_sink(flags.mcap, flags.out, prepared.method->name(), prepared.input.source->info());
  SlamRunEnd end = slam_run(wired(prepared, folder, bar, live.get(), mcap.get()));
  bar.clear();
  if (!live) prepared.slam.reset();  // its memory is needed for the files; a page may still ask it
  finish_recording(prepared.input, end.result.timing.live);
  end.result.method.name = prepared.method->name();
  if (end.result.frames == 0 && !end.result.interrupted) refuse_without_frames(end, folder, flags.data.path);
  const SlamTask task = task_of(prepared.context);
  const SlamOutputs outputs = write_slam_outputs(end, folder, prepared.context, task);
  folder.write_result(to_json(end.result));
  if (mcap) mcap->finish(end, *prepared.pool);
  if (end.failure) std::rethrow_exception(end.failure);
  if (flags.data.json) {
    fmt::print("{}", to_json(end.result));
  } else if (!flags.data.quiet) {
    fmt::print("{}", slam_summary(end, outputs, flags.out, task));
  }
  const int exit_code = report_missed(prepared.limits, limit_numbers_of(end.result));
  if (live) {
    live->finish(end);
    live->wait_until_closed();
  }
  return exit_code;
}

void add_slam_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("slam", "Estimates trajectory and map by SLAM, with cameras or a 2D laser");
  const auto flags = std::make_shared<SlamFlags>();
  add_slam_flags(*command, *flags);
  command->callback([command, flags, &context] {
    flags->seed_given = command->count("--seed") > 0;
    if (!flags->map.empty() && !flags->extend)
      throw Error("requires --continue", "--map", "to localize in a map, use 'rastro localize DATA --map MAP'");
    context.exit_code = run_slam(*flags);
  });
}

}  // namespace rastro::cli
