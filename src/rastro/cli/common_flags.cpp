// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/common_flags.h"

#include <fmt/format.h>

#include "rastro/base/error.h"
#include "rastro/base/text.h"

namespace rastro::cli {
namespace {

constexpr const char* data_help =
    "Recording: a EuRoC/ASL folder, a TUM RGB-D folder, a KITTI odometry sequence, a KITTI raw drive, a folder or "
    "quoted "
    "pattern of images, a video, a laser log (CARMEN or minesrover, packed or not), a landmark log, or a ROS 1 bag";

std::int64_t frame_number(std::string_view text, std::int64_t if_empty, const std::string& whole) {
  if (trim(text).empty()) return if_empty;
  const auto number = parse_int64(text);
  if (!number || *number < 0) {
    throw Error(fmt::format("{} is no range of frames", in_quotes(whole)), "--frames",
                "give A:B, such as 100:200 (without 200), :50 or 100:");
  }
  return *number;
}

void set_frames(const std::string& text, OpenOptions& options) {
  if (text.empty()) return;
  const auto ends = split(text, ':');
  if (ends.size() != 2) frame_number("?", 0, text);
  options.first_frame = frame_number(ends[0], options.first_frame, text);
  options.end_frame = frame_number(ends[1], options.end_frame, text);
  if (options.first_frame >= options.end_frame) {
    throw Error(fmt::format("{} holds no frame", in_quotes(text)), "--frames", "give A:B with A below B");
  }
}

std::array<double, 4> parse_intrinsics(const std::string& text) {
  const auto pieces = split(text, ',');
  std::array<double, 4> values{};
  bool good = pieces.size() == values.size();
  for (std::size_t i = 0; good && i < values.size(); ++i) {
    const auto value = parse_finite(pieces[i]);
    good = value.has_value();
    if (good) values[i] = *value;
  }
  if (!good || values[0] <= 0.0 || values[1] <= 0.0) {
    throw Error(fmt::format("{} is not fx,fy,cx,cy", in_quotes(text)), "--intrinsics",
                "give four numbers of pixels, such as 458.7,457.3,367.2,248.4");
  }
  return values;
}

}  // namespace

void add_data_flags(CLI::App& command, DataFlags& flags) {
  const std::string data = "Which data", calibration = "Calibration (found by itself where the data has one)",
                    run = "Run";
  command.add_option("DATA", flags.path, data_help)->required();
  command.add_option("--frames", flags.frames, "Frames A to B-1 only, counted from 0; either end may be left out")
      ->type_name("A:B")
      ->group(data);
  command.add_option("--every", flags.every, "Only each N-th frame")
      ->type_name("N")
      ->capture_default_str()
      ->group(data);
  command.add_option("--rate", flags.rate_hz, "Frames a second where the data has no stamps [the format's usual rate]")
      ->type_name("HZ")
      ->group(data);
  command.add_option("--camera", flags.camera, "Which camera, such as cam1 or image_2 [the left or only one]")
      ->type_name("NAME")
      ->group(data);
  command.add_option("--calibration", flags.calibration, "EuRoC, KITTI, OpenCV, ROS or Kalibr calibration file")
      ->type_name("FILE")
      ->group(calibration);
  command.add_option("--intrinsics", flags.intrinsics, "Pinhole camera without distortion, in pixels")
      ->type_name("fx,fy,cx,cy")
      ->group(calibration);
  command
      .add_option("--fov", flags.fov_deg, "Horizontal field of view in degrees: a guess where nothing better is known")
      ->type_name("DEG")
      ->group(calibration);
  command.add_option("--threads", flags.threads, "Threads, 0 = all of the machine; no result depends on it")
      ->type_name("N")
      ->capture_default_str()
      ->group(run);
  command.add_option("--seed", flags.seed, "Seed of everything random")
      ->type_name("N")
      ->capture_default_str()
      ->group(run);
  command.add_flag("--json", flags.json, "Print the result as JSON on standard output")->group(run);
  command.add_flag("--quiet", flags.quiet, "No log and no progress on standard error")->group(run);
}

OpenOptions open_options(const DataFlags& flags) {
  OpenOptions options;
  set_frames(flags.frames, options);
  if (flags.every < 1)
    throw Error(fmt::format("each {}-th frame makes no sense", flags.every), "--every", "give 1 or more");
  options.every = flags.every;
  if (!(flags.rate_hz >= 0.0 && flags.rate_hz <= 1e6)) {
    throw Error(fmt::format("{:g} is no frame rate", flags.rate_hz), "--rate", "give frames a second, such as 30");
  }
  options.rate_hz = flags.rate_hz;
  options.camera = flags.camera;
  if (flags.threads < 0) {
    throw Error(fmt::format("{} threads make no sense", flags.threads), "--threads", "give 1 or more, or 0 for all");
  }
  if (!flags.intrinsics.empty() && !flags.calibration.empty()) {
    throw Error("contradicts --calibration", "--intrinsics", "give one of them");
  }
  if (!flags.intrinsics.empty()) options.intrinsics = parse_intrinsics(flags.intrinsics);
  options.calibration_file = flags.calibration;
  if (flags.fov_deg != 0.0) {
    if (!(flags.fov_deg > 1.0 && flags.fov_deg < 179.0)) {
      throw Error(fmt::format("{:g} degrees are no field of view of a pinhole camera", flags.fov_deg), "--fov",
                  "give the horizontal angle, between 1 and 179");
    }
    options.field_of_view_deg = flags.fov_deg;
  }
  return options;
}

}  // namespace rastro::cli
