// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/cli/command.h"
#include "rastro/cli/live_flags.h"
#include "rastro/cli/progress_bar.h"
#include "rastro/dataset/live/live.h"
#include "rastro/dataset/record/recording_writer.h"
#include "rastro/session/frame_reader.h"
#include "rastro/session/run_loop.h"

namespace rastro::cli {
namespace {

constexpr const char* record_footer = R"(
The recording is in EuRoC/ASL layout (mav0/cam0, and mav0/cam1 of a stereo pair), or in that of TUM RGB-D where the
source has depth. It grows as frames come: images are lossless PNG, stamps are the source's own, the calibration is
written beside them. A recording that is stopped (Ctrl-C), killed or ended by a full disk has all frames up to there.
Every command reads it. 'rastro slam SOURCE --record DIR' records while it runs a method.

Examples:
  rastro record v4l2:/dev/video0,1280x720@30 --out walk --calibration camera.yaml
  rastro record openni2: --out room
  rastro record http://192.168.1.20:8080/video --out walk
  ffmpeg -i walk.mp4 -f yuv4mpegpipe - | rastro record pipe: --rate 30 --out walk
  rastro record replay:kitti/00 --out copy
  rastro slam copy --method orb --out run)";

struct Recorded {
  std::int64_t frames = 0;
  TimeNs first = 0, last = 0;
  std::int64_t skipped = 0;
};

void count(Recorded& recorded, const Frame& frame) {
  if (recorded.frames++ == 0) recorded.first = frame.stamp;
  recorded.last = frame.stamp;
}

void report(const RunFlags& flags, const Recorded& recorded, const LiveStatistics& live, bool interrupted) {
  const double seconds = to_seconds(recorded.last - recorded.first);
  if (flags.data.json) {
    nlohmann::ordered_json json{{"out", flags.out},
                                {"frames", recorded.frames},
                                {"skipped_frames", recorded.skipped},
                                {"dropped_frames", live.dropped + live.lost},
                                {"seconds", seconds},
                                {"losses", live.losses},
                                {"interrupted", interrupted}};
    fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  } else if (!flags.data.quiet) {
    fmt::print("{}{} frames of {:.1f} s recorded in {}; {} dropped\n", interrupted ? "interrupted: " : "",
               recorded.frames, seconds, flags.out, live.dropped + live.lost);
  }
}

void record(const RunFlags& flags) {
  if (!is_live(flags.data.path))
    throw Error("is not a live source", flags.data.path, std::string("give ") + live_forms);
  OpenOptions options = open_options(flags.data);
  options.want_color = options.want_depth = options.want_right = true;
  RunInput input = open_run_input(flags, options, "writing");
  for (const std::string& warning : input.source->info().warnings) log_warning(warning);
  RecordingWriter writer(input.source->info(), flags.out);
  FrameReader reader(*input.source, nullptr);
  ProgressBar bar(!flags.data.quiet);
  Recorded recorded;
  const RunLoopEnd end = run_loop(reader, input.live, nullptr, [&](Frame& frame) {
    writer.write(frame);
    input.live->note_pose();
    count(recorded, frame);
    bar.show(SlamProgress{recorded.frames, std::nullopt, 0, nullptr, nullptr});
  });
  bar.clear();
  recorded.skipped = reader.skipped();
  if (recorded.frames == 0 && !end.failure && !end.interrupted)
    throw Error("has no frames", flags.data.path, "'rastro check' checks a recording");
  if (recorded.frames > 0) report(flags, recorded, input.live->statistics(), end.interrupted);
  if (end.failure) std::rethrow_exception(end.failure);
}

}  // namespace

void add_record_command(CLI::App& app, Context&) {
  CLI::App* command = app.add_subcommand("record", "Records a live source, lossless, as it comes");
  const auto flags = std::make_shared<RunFlags>();
  flags->live.queue = 32;
  flags->live.drains = true;
  command->add_option("--out", flags->out, "Output folder; new or empty")->type_name("DIR")->required();
  add_live_flags(*command, flags->live, "the disk");
  add_data_flags(*command, flags->data);
  command->footer(record_footer);
  command->callback([flags] {
    if (flags->data.quiet) set_log_sink({});
    record(*flags);
  });
}

}  // namespace rastro::cli
