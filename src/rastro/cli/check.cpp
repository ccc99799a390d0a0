// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/check.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <memory>

#include "rastro/base/log.h"
#include "rastro/cli/command.h"
#include "rastro/cli/common_flags.h"

namespace rastro::cli {
namespace {

constexpr const char* footer =
    "Reads every image, scan or sighting and reports: frame count and rate, gaps, repeated and backward stamps, the\n"
    "unit of the stamps, unreadable images, changes of size, missing calibration, offsets between depth and colour,\n"
    "overlap with the ground truth; shape of the scans, shares of beams that measured something, nothing or are "
    "broken,\n"
    "jumps of the odometry. Goes on after broken frames. Exit code 0: can be used (perhaps with warnings); 2: cannot,\n"
    "with the reason.\n"
    "\n"
    "Examples:\n"
    "  rastro check MH_01_easy                       everything\n"
    "  rastro check freiburg1_desk --frames 0:100    the first hundred frames\n"
    "  rastro check intel.clf.gz                     a laser log\n"
    "  rastro check sequences/00 --json > check.json every finding, for programs";

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
  CLI::App* command = app.add_subcommand("check", "Look for everything that is wrong with a recording");
  const auto flags = std::make_shared<DataFlags>();
  add_data_flags(*command, *flags);
  command->footer(footer);
  command->callback([flags, &context] {
    if (flags->quiet) set_log_sink({});
    const bool progress = !flags->quiet && isatty(STDERR_FILENO) == 1;
    const auto report =
        rastro::check(flags->path, open_options(*flags),
                      progress ? std::function(show_progress) : std::function<void(std::int64_t, std::int64_t)>());
    fmt::print("{}", flags->json ? to_json(report) : to_text(report));
    context.exit_code = report.usable ? done : unusable;
  });
}

}  // namespace rastro::cli
