// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <memory>

#include "rastro/base/error.h"
#include "rastro/base/hash.h"
#include "rastro/base/log.h"
#include "rastro/base/task_pool.h"
#include "rastro/cli/command.h"
#include "rastro/cli/interrupt.h"
#include "rastro/cli/live_flags.h"
#include "rastro/cli/live_tracks.h"
#include "rastro/cli/masks.h"
#include "rastro/cli/program.h"
#include "rastro/cli/progress_bar.h"
#include "rastro/cli/track_flags.h"
#include "rastro/cli/track_outputs.h"
#include "rastro/cli/track_summary.h"
#include "rastro/dataset/open.h"
#include "rastro/dataset/recording.h"
#include "rastro/session/run_folder.h"
#include "rastro/session/track_run.h"
#include "rastro/track/tracker.h"

namespace rastro::cli {
namespace {

constexpr const char* no_calibration_warning =
    "no calibration found: the tracks have no undistorted rays; give --calibration FILE, --intrinsics fx,fy,cx,cy or "
    "--fov DEG to get them";

TracksHeader header_of(const OptionTable& table, const std::optional<Camera>& camera) {
  TracksHeader header;
  for (std::size_t i = 0; i < table.options().size(); ++i) {
    header.options.emplace_back(table.options()[i].name, table.value_of(i));
  }
  header.camera = camera;
  return header;
}

std::string hash_of(const TracksHeader& header) {
  Sha256 hash;
  for (const auto& [name, value] : header.options) hash.add(fmt::format("{}={}\n", name, value));
  return hash.finish();
}

std::optional<std::int64_t> frames_asked(const SourceInfo& info, const OpenOptions& options) {
  if (info.frame_count < 0) return std::nullopt;
  return FrameChoice(options, info.frame_count, info.path).count;
}

/// Everything that can be wrong with flags and input is found here, before a folder is made.
struct Prepared {
  TrackOptions options;
  OptionTable table;
  std::vector<Limit> limits;
  RunInput input;
  std::optional<Camera> camera;
  std::optional<std::int64_t> frames;
  std::optional<Masks> masks;
  std::unique_ptr<TaskPool> pool;
  std::unique_ptr<Tracker> tracker;
};

std::unique_ptr<Prepared> prepare(const TrackFlags& flags) {
  auto run = std::make_unique<Prepared>();  // the table points into it, so it must not move
  run->table = option_table(run->options);
  apply_preset(flags, run->options);
  apply_settings(flags, run->table);
  for (const std::string& limit : flags.limits) run->limits.emplace_back(limit);
  check_outputs(flags);
  const OpenOptions open = open_options(flags.data);
  run->input = open_run_input(flags, open);
  const SourceInfo& info = run->input.source->info();
  if (!info.has_image) throw Error("has no images to track", info.path, "'rastro slam' reads laser scans");
  run->frames = frames_asked(info, open);
  if (!info.cameras.empty()) run->camera = info.cameras.front().camera;
  if (!flags.mask.empty()) run->masks.emplace(flags.mask);
  run->pool = std::make_unique<TaskPool>(flags.data.threads);
  run->tracker = std::make_unique<Tracker>(run->options, run->camera, run->pool.get());
  return run;
}

void warn_about(const Prepared& run) {
  for (const std::string& warning : run.input.source->info().warnings) {
    // The warning below also says what the tracks lack.
    if (run.camera || !warning.starts_with("no calibration found")) log_warning(warning);
  }
  if (!run.camera) log_warning(no_calibration_warning);
}

/// Null without --view.
std::unique_ptr<LiveTracks> live_view(const TrackFlags& flags, const Prepared& prepared) {
  const auto hello = live_hello(flags, "track", prepared.frames);
  return hello ? std::make_unique<LiveTracks>(flags.server, *hello) : nullptr;
}

TrackRun wired(Prepared& prepared, RunFolder& folder, const TrackOutputs& outputs, ProgressBar& bar, LiveTracks* live) {
  TrackRun run;
  run.source = prepared.input.source.get();
  run.live = prepared.input.live;
  run.process = [&prepared](GrayView image, TimeNs stamp, GrayView mask) {
    return prepared.tracker->process(image, stamp, mask);
  };
  if (prepared.masks) run.mask_of = [&prepared](const Frame& frame) { return prepared.masks->mask_of(frame); };
  run.sinks = outputs.text_sinks();
  if (live != nullptr) run.sinks.push_back(live);
  run.image_sinks = outputs.image_sinks();
  run.folder = &folder;
  run.stop = &catch_interrupts();
  run.frames_asked = prepared.frames;
  // Warnings wait for the first frame: where there is none, the one line to read is why.
  run.progress = [&bar, &prepared, warned = false](const TrackProgress& progress) mutable {
    if (!warned) warn_about(prepared);
    warned = true;
    bar.show(progress);
  };
  return run;
}

int missed_limits(const std::vector<Limit>& limits, const TrackResult& result) {
  int code = done;
  for (const Limit& limit : limits) {
    if (limit.kept_by(result)) continue;
    fmt::print(stderr, "rastro: --require {}\n", limit.complaint(result));
    code = limit_missed;
  }
  return code;
}

void refuse_empty_run(const TrackRunEnd& end, const std::string& path) {
  if (end.failure) std::rethrow_exception(end.failure);
  if (end.result.frames > 0 || end.result.interrupted) return;
  throw Error(end.first_skip.empty() ? "has no frames" : "no frame could be read; the first: " + end.first_skip, path,
              "'rastro check' lists what is wrong");
}

int run_track(const TrackFlags& flags) {
  if (flags.data.quiet) set_log_sink({});
  const std::unique_ptr<Prepared> prepared = prepare(flags);
  const std::unique_ptr<LiveTracks> live = live_view(flags, *prepared);
  RunFolder folder(flags.out, flags.force);
  folder.write_about(prepared->input.source->info(), command_line());
  folder.write_options(prepared->table);
  const TracksHeader header = header_of(prepared->table, prepared->camera);
  TrackOutputs outputs(flags, folder, header);
  watch_while_idle(prepared->input, live.get());
  ProgressBar bar(!flags.data.quiet);
  TrackRunEnd end = track_run(wired(*prepared, folder, outputs, bar, live.get()));
  bar.clear();
  finish_recording(prepared->input, end.result.live);
  end.result.result_sha256 = outputs.result_sha256();
  end.result.options_sha256 = hash_of(header);
  const bool has_frames = end.result.frames > 0 || end.result.interrupted;
  has_frames ? folder.write_result(to_json(end.result)) : folder.discard();
  refuse_empty_run(end, flags.data.path);
  if (flags.data.json) {
    fmt::print("{}", to_json(end.result));
  } else if (!flags.data.quiet) {
    fmt::print("{}", track_summary(end, flags.out, outputs.contents(), hints_for(end)));
  }
  if (live) {
    live->finish(end);
    live->wait_until_closed();
  }
  return missed_limits(prepared->limits, end.result);
}

}  // namespace

void add_track_command(CLI::App& app, Context& context) {
  CLI::App* command =
      app.add_subcommand("track", "Tracks features through a recording and re-identifies them after occlusions");
  const auto flags = std::make_shared<TrackFlags>();
  add_track_flags(*command, *flags);
  command->callback([command, flags, &context] {
    const CLI::Option* seed = command->get_option_no_throw("--seed");
    flags->seed_given = seed != nullptr && seed->count() > 0;
    context.exit_code = run_track(*flags);
  });
}

}  // namespace rastro::cli
