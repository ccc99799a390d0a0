// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "rastro/base/append_file.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/cli/command.h"
#include "rastro/cli/common_flags.h"
#include "rastro/cli/interrupt.h"
#include "rastro/dataset/open.h"
#include "rastro/dataset/scan_from_depth.h"
#include "rastro/sensor/scan_text.h"

namespace rastro::cli {
namespace {

constexpr const char* convert_footer =
    R"(scan: CARMEN log (ROBOTLASER1), which every command reads back exactly. Scans of a laser are written as they are. From a
depth camera a scan is cut out of each depth image, as by ROS' depthimage_to_laserscan: the nearest point in every
direction, of the points within a band of heights; the camera is assumed to be level. Wheel odometry is kept.

Examples:
  rastro convert freiburg1_desk --to scan --out desk.log
  rastro convert kitchen --to scan --height -0.2:0.1 --out kitchen.log
  rastro convert robot.bag --to scan --out robot.log)";

struct ConvertFlags {
  DataFlags data;
  std::string to;
  std::string out;
  std::string height;
  ScanFromDepthOptions cut;
};

struct Written {
  std::int64_t scans = 0, skipped = 0;
  std::int64_t beams = 0, returns = 0, free = 0;
  bool interrupted = false;
};

double share(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

void set_height(const std::string& text, ScanFromDepthOptions& options) {
  if (text.empty()) return;
  const auto ends = split(text, ':');
  const auto lowest = ends.size() == 2 ? parse_finite(ends[0]) : std::nullopt;
  const auto highest = ends.size() == 2 ? parse_finite(ends[1]) : std::nullopt;
  if (!lowest || !highest)
    throw Error(in_quotes(text) + " is not a range of heights", "--height", "give A:B in meters, such as -0.2:0.1");
  options.lowest = *lowest;
  options.highest = *highest;
}

void require_scans_or_depth(const SourceInfo& info) {
  if (info.has_scan) return;
  if (!info.has_depth)
    throw Error("has neither depth images nor laser scans", info.path, "'rastro info' lists what it has");
  if (info.cameras.empty() || !info.cameras.front().camera)
    throw Error("the calibration of the depth camera is unknown", info.path,
                "give --calibration, --intrinsics or --fov");
}

void refuse_own_data(const std::string& data, const std::string& out) {
  std::error_code ignored;
  if (std::filesystem::equivalent(data, out, ignored))
    throw Error("would overwrite the data itself", out, "give another --out");
}

/// The scan of one frame; nullopt where it has neither scan nor depth.
std::optional<LaserScan> scan_of(Frame& frame, const SourceInfo& info, std::optional<ScanFromDepth>& cutter,
                                 const ScanFromDepthOptions& options) {
  if (frame.scan || frame.depth.empty()) return std::move(frame.scan);
  Camera camera = *info.cameras.front().camera;
  camera.width = frame.depth.width();
  camera.height = frame.depth.height();
  if (!cutter) cutter.emplace(camera, options);
  return cutter->cut(frame.depth);
}

/// Opened by the first scan: data that gives none leaves an existing file as it is.
class ScanFile {
 public:
  explicit ScanFile(std::string path) : path_(std::move(path)) {}

  void append(const std::string& line) {
    if (!file_) file_.emplace(path_).append(carmen_header());
    file_->append(line);
  }

 private:
  std::string path_;
  std::optional<AppendFile> file_;
};

Written write_scans(Source& source, const ScanFromDepthOptions& options, ScanFile& file) {
  Written written;
  std::optional<ScanFromDepth> cutter;
  const std::atomic<bool>& stop = catch_interrupts();
  for (;;) {
    written.interrupted = stop.load();
    if (written.interrupted) return written;
    std::optional<Frame> frame;
    try {
      frame = source.next();
    } catch (const UnusableSource&) {
      throw;
    } catch (const Error& error) {
      log_warning(error.what());
      ++written.skipped;
      continue;
    }
    if (!frame) return written;
    const auto scan = scan_of(*frame, source.info(), cutter, options);
    if (!scan) {
      ++written.skipped;
      continue;
    }
    file.append(carmen_robot_laser_line(*scan, frame->odometry_from_body.value_or(SE2()), frame->stamp));
    ++written.scans;
    written.beams += static_cast<std::int64_t>(scan->ranges.size());
    for (std::size_t beam = 0; beam < scan->ranges.size(); ++beam) {
      written.returns += scan->is_return(beam) ? 1 : 0;
      written.free += scan->is_free(beam) ? 1 : 0;
    }
  }
}

void report(const ConvertFlags& flags, const Written& written) {
  if (flags.data.json) {
    nlohmann::ordered_json json;
    json["out"] = flags.out;
    json["scans"] = written.scans;
    json["skipped"] = written.skipped;
    json["interrupted"] = written.interrupted;
    json["beams"] = written.beams;
    json["returns_share"] = share(written.returns, written.beams);
    json["free_share"] = share(written.free, written.beams);
    fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  } else if (!flags.data.quiet) {
    fmt::print("{}{} scans written to {}, {} frames skipped; {:.1f} % of the beams are returns, {:.1f} % are free\n",
               written.interrupted ? "interrupted: " : "", written.scans, flags.out, written.skipped,
               100.0 * share(written.returns, written.beams), 100.0 * share(written.free, written.beams));
  }
}

void convert(ConvertFlags& flags) {
  if (flags.to != "scan") throw Error(in_quotes(flags.to) + " is not a format", "--to", "give scan");
  set_height(flags.height, flags.cut);
  OpenOptions options = open_options(flags.data);
  options.want_depth = true;
  const auto source = rastro::open(flags.data.path, options);
  require_scans_or_depth(source->info());
  for (const std::string& warning : source->info().warnings) log_warning(warning);
  refuse_own_data(flags.data.path, flags.out);
  ScanFile file(flags.out);
  const Written written = write_scans(*source, flags.cut, file);
  if (written.scans == 0) throw Error("no frame gave a scan", flags.data.path, "'rastro check' lists what is wrong");
  if (written.returns == 0)
    log_warning("no beam of any scan met anything; of depth images, --height may be beside all that they see");
  report(flags, written);
}

}  // namespace

void add_convert_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("convert", "Converts depth images or laser scans to a CARMEN log");
  const auto flags = std::make_shared<ConvertFlags>();
  add_data_flags(*command, flags->data);
  command->add_option("--to", flags->to, "Output format: scan")->type_name("KIND")->required();
  command->add_option("--out", flags->out, "Output file")->type_name("FILE")->required();
  command
      ->add_option("--height", flags->height,
                   "Depth images: heights relative to the camera, in meters (default: -0.05:0.05)")
      ->type_name("A:B");
  command
      ->add_option("--max-range", flags->cut.max_range,
                   "Depth images: maximum range in meters; beyond it a beam is free")
      ->type_name("M")
      ->capture_default_str();
  command->footer(convert_footer);
  command->callback([flags, &context] {
    if (flags->data.quiet) set_log_sink({});
    convert(*flags);
    context.exit_code = done;
  });
}

}  // namespace rastro::cli
