// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/describe.h"

#include <fmt/format.h>

#include <numbers>
#include <string_view>

#include "rastro/dataset/describe_fields.h"

namespace rastro {
namespace {

using Json = nlohmann::ordered_json;

constexpr double degrees_per_radian = 180.0 / std::numbers::pi;

std::string_view distortion_name(Distortion distortion) {
  switch (distortion) {
    case Distortion::radial_tangential:
      return "radial-tangential";
    case Distortion::equidistant:
      return "equidistant";
    case Distortion::rational:
      return "rational polynomial";
    case Distortion::none:
      break;
  }
  return "none";
}

void add_line(std::string& text, std::string_view name, const std::string& value) {
  text += fmt::format("{:<14}{}\n", name, value);
}

std::string frames_line(const SourceInfo& info) {
  const auto count = info.frame_count < 0 ? std::string("an unknown number") : fmt::format("{}", info.frame_count);
  return count + (info.has_stamps ? "" : ", stamps made up");
}

std::string ground_truth_line(const SourceInfo& info) {
  const auto& ground_truth = info.ground_truth;
  const double span = to_seconds(ground_truth.back().stamp - ground_truth.front().stamp);
  double length = 0.0;
  for (std::size_t k = 1; k < ground_truth.size(); ++k) {
    length +=
        (ground_truth[k].world_from_body.translation() - ground_truth[k - 1].world_from_body.translation()).norm();
  }
  return fmt::format("{} poses of the {} over {:.2f} s, path {:.2f} m ({})", ground_truth.size(),
                     info.ground_truth_frame, span, length, info.ground_truth_file);
}

Json camera_fields(const CalibratedCamera& calibrated) {
  Json fields = {{"name", calibrated.name}, {"calibrated", calibrated.camera.has_value()}};
  if (!calibrated.camera) return fields;
  const auto& camera = *calibrated.camera;
  fields["calibration_file"] = calibrated.calibration_file;
  fields["width"] = camera.width;
  fields["height"] = camera.height;
  fields["intrinsics"] = {camera.fx, camera.fy, camera.cx, camera.cy};
  if (camera.readout_s > 0.0) fields["readout_s"] = camera.readout_s;
  fields["calibration_error"] = calibrated.calibration_error;
  fields["distortion"] = distortion_name(camera.distortion);
  fields["coefficients"] =
      std::vector<double>(camera.coefficients.begin(),
                          camera.coefficients.begin() + static_cast<std::ptrdiff_t>(camera.coefficient_count()));
  return fields;
}

}  // namespace

std::string describe_camera(const Camera& camera) {
  auto text = fmt::format("{}x{}, fx fy cx cy = {:g} {:g} {:g} {:g}, ", camera.width, camera.height, camera.fx,
                          camera.fy, camera.cx, camera.cy);
  text += camera.distortion == Distortion::none ? "no distortion" : distortion_name(camera.distortion);
  for (std::size_t i = 0; i < camera.coefficient_count(); ++i) text += fmt::format(" {:g}", camera.coefficients[i]);
  if (camera.readout_s > 0.0) text += fmt::format(", rolling shutter of {:g} ms", 1e3 * camera.readout_s);
  return text;
}

std::string describe_depth_units(const SourceInfo& info) {
  std::string text = fmt::format("{:g} units a meter", info.depth_factor);
  if (info.depth_offset_m != 0.0) text += fmt::format(", {:+.1f} mm", 1e3 * info.depth_offset_m);
  return text;
}

std::string describe_scan(const LaserScan& scan) {
  const auto last = scan.ranges.empty() ? 0 : scan.ranges.size() - 1;
  return fmt::format("{} beams from {:.2f} to {:.2f} deg, {:g} to {:g} m", scan.ranges.size(),
                     scan.first_angle * degrees_per_radian, scan.angle_of(last) * degrees_per_radian, scan.min_range,
                     scan.max_range);
}

std::string describe(const SourceInfo& info, bool with_warnings, const LaserScan* first_scan) {
  std::string text;
  add_line(text, "path", info.path);
  add_line(text, "format", info.format);
  add_line(text, "frames", frames_line(info));
  for (const auto& camera : info.cameras) {
    add_line(text, "camera",
             fmt::format("{}: {}", camera.name, camera.camera ? describe_camera(*camera.camera) : "no calibration"));
    if (camera.camera) add_line(text, "", fmt::format("from {}", camera.calibration_file));
  }
  if (info.has_right) {
    const auto& pose = info.left_from_right;
    add_line(text, "stereo", pose ? fmt::format("baseline {:.4f} m", pose->translation().norm()) : "baseline unknown");
  }
  if (first_scan) add_line(text, "scans", describe_scan(*first_scan));
  if (info.has_scan || info.has_landmarks || info.has_odometry)
    add_line(text, "odometry", info.has_odometry ? "of the wheels" : "none");
  if (info.has_landmarks) add_line(text, "landmarks", "by range and bearing");
  if (info.has_imu) add_line(text, "inertial", "yes");
  if (info.has_depth) add_line(text, "depth", describe_depth_units(info));
  if (info.has_depth && info.depth_registration)
    add_line(text, "",
             fmt::format("of {}, put into the color image", describe_camera(info.depth_registration->depth_camera)));
  add_line(text, "ground truth", info.ground_truth.empty() ? "none" : ground_truth_line(info));
  if (!with_warnings) return text;
  for (const auto& warning : info.warnings) add_line(text, "warning", warning);
  return text;
}

nlohmann::ordered_json source_fields(const SourceInfo& info) {
  Json fields = {
      {"path", info.path}, {"format", info.format}, {"frame_count", info.frame_count}, {"has_stamps", info.has_stamps}};
  fields["cameras"] = Json::array();
  for (const auto& camera : info.cameras) fields["cameras"].push_back(camera_fields(camera));
  fields["has_right"] = info.has_right;
  if (info.left_from_right) fields["baseline_m"] = info.left_from_right->translation().norm();
  fields["has_image"] = info.has_image;
  fields["has_scan"] = info.has_scan;
  fields["has_odometry"] = info.has_odometry;
  fields["has_landmarks"] = info.has_landmarks;
  fields["has_imu"] = info.has_imu;
  fields["has_depth"] = info.has_depth;
  if (info.has_depth) fields["depth_factor"] = info.depth_factor;
  if (info.has_depth) fields["depth_offset_m"] = info.depth_offset_m;
  if (info.has_depth) fields["depth_is_put_into_color"] = info.depth_registration.has_value();
  fields["ground_truth_poses"] = info.ground_truth.size();
  if (!info.ground_truth.empty()) {
    fields["ground_truth_frame"] = info.ground_truth_frame;
    fields["ground_truth_file"] = info.ground_truth_file;
  }
  return fields;
}

nlohmann::ordered_json scan_fields(const LaserScan& scan) {
  const auto last = scan.ranges.empty() ? 0 : scan.ranges.size() - 1;
  return {{"beams", scan.ranges.size()},
          {"first_angle_deg", scan.first_angle * degrees_per_radian},
          {"last_angle_deg", scan.angle_of(last) * degrees_per_radian},
          {"angle_step_deg", scan.angle_step * degrees_per_radian},
          {"min_range_m", scan.min_range},
          {"max_range_m", scan.max_range}};
}

std::string describe_json(const SourceInfo& info, const LaserScan* first_scan) {
  Json fields = source_fields(info);
  if (first_scan) fields["scan"] = scan_fields(*first_scan);
  fields["warnings"] = info.warnings;
  return fields.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace rastro
