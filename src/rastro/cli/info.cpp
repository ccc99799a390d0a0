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

constexpr const char* info_footer =
    R"(Of a recording: format, frames, cameras with calibration, stereo, depth, laser scans, wheel odometry, landmarks and ground
truth, with warnings where something was guessed or looks wrong. Reads only the lists and the first image or scan;
'rastro check' reads everything. Of a map (a file or a run folder): its contents, and whether every checksum is valid.

Examples:
  rastro info MH_01_easy                        EuRoC folder
  rastro info sequences/00 --camera image_2     left color camera of a KITTI sequence
  rastro info 'photos/left*.jpg' --fov 70       images without calibration
  rastro info intel.clf.gz                      CARMEN log: beams, angles, range
  rastro info clip.mp4 --json                   machine-readable
  rastro info run/map.rastro                    map: keyframes, constraints, layers, extent, integrity)";

/// The first scan that can be read: no header has its shape.
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
  if (!report.damage.empty()) throw Error(report.damage);
}

}  // namespace

void add_info_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("info", "Describes a recording or a map");
  const auto flags = std::make_shared<DataFlags>();
  add_data_flags(*command, *flags);
  command->footer(info_footer);
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
