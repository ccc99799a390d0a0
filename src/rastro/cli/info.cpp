// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "rastro/base/log.h"
#include "rastro/cli/command.h"
#include "rastro/cli/common_flags.h"
#include "rastro/cli/describe_map.h"
#include "rastro/cli/map_path.h"
#include "rastro/dataset/describe.h"
#include "rastro/dataset/open.h"
#include "rastro/map/file/map_file.h"

namespace rastro::cli {
namespace {

constexpr const char* footer =
    "Says which format the data has, its frames, cameras with their calibration, stereo, depth, laser scans, wheel\n"
    "odometry, landmarks and ground truth, and warns of what had to be guessed or looks wrong. Reads the lists and "
    "the\n"
    "first image or scan only; 'rastro check' reads all. Of a map (a file, or the folder of its run) it says what is "
    "in\n"
    "it and whether all of it is as it was written.\n"
    "\n"
    "Examples:\n"
    "  rastro info MH_01_easy                        a EuRoC folder\n"
    "  rastro info sequences/00 --camera image_2     the left color camera of a KITTI sequence\n"
    "  rastro info 'photos/left*.jpg' --fov 70       images without calibration\n"
    "  rastro info intel.clf.gz                      a CARMEN log: beams, angles, reach\n"
    "  rastro info clip.mp4 --json                   for programs\n"
    "  rastro info run/map.rastro                    a map: keyframes, constraints, layers, extent, whether it is "
    "whole";

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

bool is_map(const std::string& path) {
  const auto file = map_file_of(path);
  // A damaged map that no longer says what it is goes by its name.
  std::error_code code;
  return is_map_file(file) || (file.extension() == ".rastro" && std::filesystem::is_regular_file(file, code));
}

void show_map(const DataFlags& flags) {
  const std::string file = map_file_of(flags.path).string();
  const MapFileReport report = check_map_file(file);
  fmt::print("{}", flags.json ? describe_map_json(report, file) : describe_map(report, file));
}

}  // namespace

void add_info_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("info", "Say what a recording or a map holds");
  const auto flags = std::make_shared<DataFlags>();
  add_data_flags(*command, *flags);
  command->footer(footer);
  command->callback([flags, &context] {
    if (flags->quiet) set_log_sink({});
    if (is_map(flags->path)) return show_map(*flags);
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
