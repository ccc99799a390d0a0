// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/live_flags.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "rastro/base/clock.h"
#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/cli/interrupt.h"
#include "rastro/dataset/live/live.h"

namespace rastro::cli {
namespace {

constexpr int most_waiting = 1000;
constexpr const char* group =
    "Live (DATA is replay:RECORDING, v4l2:/dev/video0, openni2:, http://..., rtsp://..., pipe:)";

Clock& steady_clock() {
  static SteadyClock clock;
  return clock;
}

void check(const RunFlags& flags) {
  const LiveFlags& live = flags.live;
  if (live.queue < 1 || live.queue > most_waiting)
    throw Error(fmt::format("{} is not a length of the queue", live.queue), "--queue",
                fmt::format("give 1 to {} frames", most_waiting));
  if ((live.speed != 1.0 || live.loop) && !flags.data.path.starts_with("replay:"))
    throw Error("is for replays", live.loop ? "--loop" : "--speed", "give DATA as replay:DATA");
}

/// The tap of --record.
std::function<void(const Frame&)> recorder_for(const SourceInfo& info, const std::string& folder, RunInput& input) {
  if (folder.empty()) return {};
  input.writer = std::make_unique<RecordingWriter>(info, folder);
  input.recorder =
      std::make_unique<FrameRecorder>([writer = input.writer.get()](const Frame& frame) { writer->write(frame); });
  return [recorder = input.recorder.get()](const Frame& frame) { recorder->add(frame); };
}

}  // namespace

void add_live_flags(CLI::App& command, LiveFlags& flags, const char* user) {
  command.add_option("--speed", flags.speed, "replay: times as fast as recorded")
      ->type_name("S")
      ->capture_default_str()
      ->group(group);
  command.add_flag("--loop", flags.loop, "replay: from the first frame again after the last, until Ctrl-C")
      ->group(group);
  command
      .add_option("--queue", flags.queue,
                  fmt::format("Frames that may wait for {}; beyond that the oldest are dropped and counted", user))
      ->type_name("N")
      ->capture_default_str()
      ->group(group);
}

void add_record_flag(CLI::App& command, LiveFlags& flags) {
  command
      .add_option("--record", flags.record,
                  "Also record all frames, lossless, into this folder: EuRoC layout, or TUM RGB-D with depth")
      ->type_name("DIR")
      ->group(group);
}

RunInput open_run_input(const RunFlags& flags, const OpenOptions& options, const char* user) {
  check(flags);
  RunInput input;
  if (!is_live(flags.data.path)) {
    if (!flags.live.record.empty()) throw Error("is for live sources", "--record", "omit it for a recording");
    input.source = open_disturbed(flags, options);
    return input;
  }
  if (!flags.disturbances.empty()) throw Error("is for recordings", "--disturb", "omit it for a live source");
  auto source =
      open_live(flags.data.path, options, {flags.live.speed, flags.live.loop}, steady_clock(), &catch_interrupts());
  LiveInputOptions live_options;
  live_options.queue = static_cast<std::size_t>(flags.live.queue);
  live_options.user = user;
  live_options.stop = &catch_interrupts();
  live_options.drains = flags.live.drains;
  live_options.tap = recorder_for(source->info(), flags.live.record, input);
  auto live = std::make_unique<LiveInput>(std::move(source), steady_clock(), std::move(live_options));
  log_info("live: frames come at their own time, so runs may differ");
  input.live = live.get();
  input.source = std::move(live);
  return input;
}

void finish_recording(RunInput& input, std::optional<LiveStatistics>& statistics) {
  if (!input.recorder || !statistics) return;
  constexpr std::chrono::milliseconds patient = std::chrono::seconds(60), interrupted = std::chrono::milliseconds(500);
  statistics->recording = input.recorder->finish(catch_interrupts().load() ? interrupted : patient);
}

}  // namespace rastro::cli
