// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/check.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <limits>
#include <memory>

#include "rastro/base/log.h"
#include "rastro/cli/command.h"
#include "rastro/cli/common_flags.h"
#include "rastro/dataset/open.h"
#include "rastro/input_check/input_monitor.h"

namespace rastro::cli {
namespace {

/// Frames of a recording with images that are looked at a second time; what is wrong shows within these.
constexpr std::int64_t watched_frames = 400;

/// What the frames contradict, as in a run; broken ones were reported before.
void add_input_warnings(const std::string& path, OpenOptions options, CheckReport& report) {
  options.want_depth = options.want_right = true;
  const auto source = open(path, options);
  InputMonitor monitor(source->info());
  const std::int64_t most = source->info().has_image ? watched_frames : std::numeric_limits<std::int64_t>::max();
  for (std::int64_t frames = 0; frames < most; ++frames) {
    try {
      const auto frame = source->next();
      if (!frame) break;
      monitor.add(*frame);
    } catch (const UnusableSource&) {
      break;
    } catch (const Error&) {
      continue;
    }
  }
  for (const InputWarning& warning : monitor.warnings())
    if (warning.kind != "stamps_backward") report.warnings.push_back(warning.text);  // Listed one by one already.
}

constexpr const char* check_footer =
    R"(Reads every image, scan and observation and reports frame count and rate, gaps, repeated and decreasing timestamps and
their unit, unreadable images, changes of image size, missing calibration, time offsets between depth and color, overlap
with the ground truth; of laser scans their shape, the shares of returns, free and invalid beams, and jumps of the
odometry; and what contradicts the calibration or another sensor: a swapped or unsynchronized pair, depth that is not of the
image, a wrong focal length, a laser that is stuck or mirrored, odometry of the wrong sign. Broken frames are reported and skipped. Exit code 0: usable (perhaps with warnings); 2: unusable, with the reason.

Examples:
  rastro check MH_01_easy                        all frames
  rastro check freiburg1_desk --frames 0:100     the first hundred frames
  rastro check intel.clf.gz                      a laser log
  rastro check sequences/00 --json > check.json  machine-readable)";

void show_progress(std::int64_t frame, std::int64_t count) {
  constexpr std::int64_t each = 20;
  if (frame % each != 0 && frame != count) return;
  if (count > 0) {
    fmt::print(stderr, "\rchecked {} of {} frames{}", frame, count, frame == count ? "\r\033[K" : "");
  } else {
    fmt::print(stderr, "\rchecked {} frames", frame);
  }
}

}  // namespace

void add_check_command(CLI::App& app, Context& context) {
  CLI::App* command =
      app.add_subcommand("check", "Checks a recording for gaps, bad timestamps, missing calibration and broken frames");
  const auto flags = std::make_shared<DataFlags>();
  add_data_flags(*command, *flags);
  command->footer(check_footer);
  command->callback([flags, &context] {
    if (flags->quiet) set_log_sink({});
    const bool progress = !flags->quiet && isatty(STDERR_FILENO) == 1;
    auto report =
        rastro::check(flags->path, open_options(*flags),
                      progress ? std::function(show_progress) : std::function<void(std::int64_t, std::int64_t)>());
    if (report.usable) add_input_warnings(flags->path, open_options(*flags), report);
    fmt::print("{}", flags->json ? to_json(report) : to_text(report));
    std::fflush(stdout);
    if (!report.usable) throw Error("unusable: " + report.reasons.front(), flags->path, "see the report");
    context.exit_code = done;
  });
}

}  // namespace rastro::cli
