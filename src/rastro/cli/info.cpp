// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "rastro/base/log.h"
#include "rastro/cli/command.h"
#include "rastro/cli/common_flags.h"
#include "rastro/dataset/describe.h"
#include "rastro/dataset/open.h"

namespace rastro::cli {
namespace {

constexpr const char* footer =
    "Says which format the data has, its frames, cameras with their calibration, stereo, depth, laser scans, wheel\n"
    "odometry, landmarks and ground truth, and warns of what had to be guessed or looks wrong. Reads the lists and "
    "the\n"
    "first image or scan only; 'rastro check' reads all.\n"
    "\n"
    "Examples:\n"
    "  rastro info MH_01_easy                        a EuRoC folder\n"
    "  rastro info sequences/00 --camera image_2     the left colour camera of a KITTI sequence\n"
    "  rastro info 'photos/left*.jpg' --fov 70       images without calibration\n"
    "  rastro info intel.clf.gz                      a CARMEN log: beams, angles, reach\n"
    "  rastro info clip.mp4 --json                   for programs";

/// The first scan that can be read: its shape stands in no header.
std::optional<LaserScan> first_scan(Source& source) {
  if (!source.info().has_scan) return std::nullopt;
  for (;;) {
    try {
      auto frame = source.next();
      return frame ? frame->scan : std::nullopt;
    } catch (const Error&) {
    }
  }
}

}  // namespace

void add_info_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("info", "Say what a recording holds");
  const auto flags = std::make_shared<DataFlags>();
  add_data_flags(*command, *flags);
  command->footer(footer);
  command->callback([flags, &context] {
    if (flags->quiet) set_log_sink({});
    auto options = open_options(*flags);
    options.read_ahead = 0;
    const auto source = rastro::open(flags->path, options);
    const auto scan = first_scan(*source);
    const LaserScan* shown = scan ? &*scan : nullptr;
    fmt::print("{}", flags->json ? describe_json(source->info(), shown) : describe(source->info(), true, shown));
    context.exit_code = done;
  });
}

}  // namespace rastro::cli
