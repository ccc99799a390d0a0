// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/common_flags.h"

#include <fmt/format.h>

#include "rastro/base/error.h"
#include "rastro/base/text.h"

namespace rastro::cli {
namespace {

constexpr const char* data_help =
    "Recording: a EuRoC/ASL, TUM RGB-D, KITTI odometry or KITTI raw folder, a folder or quoted glob of images, a "
    "video, a laser log (CARMEN or minesrover, also gzipped), a landmark log, or a ROS 1 bag";

std::int64_t frame_number(std::string_view text, std::int64_t if_empty, const std::string& whole) {
  if (trim(text).empty()) return if_empty;
  const auto number = parse_int64(text);
  if (!number || *number < 0) {
    throw Error(fmt::format("{} is not a range of frames", in_quotes(whole)), "--frames",
                "give A:B, such as 100:200 (frames 100 to 199), :50 or 100:");
  }
  return *number;
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
                "give four numbers in pixels, such as 458.7,457.3,367.2,248.4");
  }
  return values;
}

}  // namespace

void set_frames(const std::string& text, OpenOptions& options) {
  if (text.empty()) return;
  const auto ends = split(text, ':');
  if (ends.size() != 2) frame_number("?", 0, text);
  options.first_frame = frame_number(ends[0], options.first_frame, text);
  options.end_frame = frame_number(ends[1], options.end_frame, text);
  if (options.first_frame >= options.end_frame) {
    throw Error(fmt::format("{} is an empty range of frames", in_quotes(text)), "--frames", "give A:B with A below B");
  }
}

void add_data_flags(CLI::App& command, DataFlags& flags) {
  const std::string data = "Input", calibration = "Calibration (default: that of the recording)", run = "General";
  command.add_option("DATA", flags.path, data_help)->type_name("")->required();
  command
      .add_option("--frames", flags.frames,
                  "Frames A to B-1 only, counted from 0; A or B may be omitted (default: all)")
      ->type_name("A:B")
      ->group(data);
  command.add_option("--every", flags.every, "Every N-th frame only")
      ->type_name("N")
      ->capture_default_str()
      ->group(data);
  command
      .add_option("--rate", flags.rate_hz, "Frame rate in Hz for data without timestamps (default: that of the format)")
      ->type_name("HZ")
      ->group(data);
  command.add_option("--camera", flags.camera, "Camera, such as cam1 or image_2 (default: the left or only one)")
      ->type_name("NAME")
      ->group(data);
  command
      .add_option("--calibration", flags.calibration,
                  "Calibration file of EuRoC, KITTI, OpenCV, ROS (camera_info) or Kalibr")
      ->type_name("FILE")
      ->group(calibration);
  command.add_option("--intrinsics", flags.intrinsics, "Pinhole intrinsics in pixels, without distortion")
      ->type_name("fx,fy,cx,cy")
      ->group(calibration);
  command
      .add_option("--fov", flags.fov_deg,
                  "Horizontal field of view in degrees, for a pinhole camera of unknown calibration")
      ->type_name("DEG")
      ->group(calibration);
  command
      .add_option("--readout-time", flags.readout_s,
                  "Seconds in which a rolling shutter reads an image; 0: a global shutter (default: that of the "
                  "calibration)")
      ->type_name("S")
      ->group(calibration);
  command
      .add_option("--calibration-error", flags.calibration_error,
                  "Standard deviation of focal length and baseline or scale of depth, as share, for the covariances of "
                  "poses (default: that of the calibration, else 0.005)")
      ->type_name("SHARE")
      ->group(calibration);
  command.add_option("--threads", flags.threads, "Number of threads, 0: all cores; results do not depend on it")
      ->type_name("N")
      ->capture_default_str()
      ->group(run);
  command.add_option("--seed", flags.seed, "Seed of the random numbers")
      ->type_name("N")
      ->capture_default_str()
      ->group(run);
  command.add_flag("--json", flags.json, "Print the result as JSON")->group(run);
  command.add_flag("--quiet", flags.quiet, "No log, progress bar or summary")->group(run);
}

OpenOptions open_options(const DataFlags& flags) {
  OpenOptions options;
  set_frames(flags.frames, options);
  if (flags.every < 1) throw Error(fmt::format("{} is not a step", flags.every), "--every", "give 1 or more");
  options.every = flags.every;
  if (flags.rate_hz && !(*flags.rate_hz > 0.0 && *flags.rate_hz <= 1e6))
    throw Error(fmt::format("{:g} is not a frame rate", *flags.rate_hz), "--rate", "give Hz, such as 30");
  options.rate_hz = flags.rate_hz.value_or(0.0);
  options.camera = flags.camera;
  if (flags.threads < 0) {
    throw Error(fmt::format("{} is not a number of threads", flags.threads), "--threads",
                "give 1 or more, or 0 for all cores");
  }
  if (!flags.intrinsics.empty() && !flags.calibration.empty()) {
    throw Error("cannot be combined with --calibration", "--intrinsics", "give one of the two");
  }
  if (!flags.intrinsics.empty()) options.intrinsics = parse_intrinsics(flags.intrinsics);
  options.calibration_file = flags.calibration;
  if (flags.readout_s != -1.0) {
    if (!(flags.readout_s >= 0.0 && flags.readout_s <= 1.0)) {
      throw Error(fmt::format("{:g} s is not a readout time", flags.readout_s), "--readout-time",
                  "give the seconds from the first row to the last, such as 0.03");
    }
    options.readout_s = flags.readout_s;
  }
  if (flags.calibration_error != -1.0) {
    if (!(flags.calibration_error >= 0.0 && flags.calibration_error <= 1.0)) {
      throw Error(fmt::format("{:g} is not a share", flags.calibration_error), "--calibration-error",
                  "give a number from 0 to 1: 0.005 says half a percent");
    }
    options.calibration_error = flags.calibration_error;
  }
  if (flags.fov_deg != 0.0) {
    if (!(flags.fov_deg > 1.0 && flags.fov_deg < 179.0)) {
      throw Error(fmt::format("{:g} degrees is not a field of view of a pinhole camera", flags.fov_deg), "--fov",
                  "give the horizontal angle, more than 1 and less than 179 degrees");
    }
    options.field_of_view_deg = flags.fov_deg;
  }
  return options;
}

}  // namespace rastro::cli
