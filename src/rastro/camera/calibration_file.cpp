// SPDX-License-Identifier: Apache-2.0
#include "rastro/camera/calibration_file.h"

#include <filesystem>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/camera/file/formats.h"
#include "rastro/camera/file/yaml_fields.h"

namespace rastro {
namespace {

/// Calibrations with all their board views are far smaller; an image or a bag named by mistake is not.
constexpr std::uintmax_t largest_file = 4 << 20;

void require_size(std::uintmax_t size, std::string_view where) {
  if (size > largest_file)
    throw Error("too large for a calibration (over 4 MiB)", where, "name the calibration file itself");
}

void require_text(std::string_view text, std::string_view where) {
  require_size(text.size(), where);
  if (text.find('\0') != std::string_view::npos)
    throw Error("not a text file", where, "name a calibration file (.yaml, .yml or .txt)");
}

Calibration parse_yaml(std::string_view text, std::string_view where) {
  using namespace calibration;
  const auto root = YamlFields::parse(text, where);
  try {
    if (is_kalibr(root)) return parse_kalibr(root);
    if (is_euroc(root)) return parse_euroc(root);
    if (is_opencv_or_ros(root)) return parse_opencv_or_ros(root);
  } catch (const YAML::Exception& error) {
    throw Error(one_line(error.msg), at_line(where, error.mark.line + 1), "");
  }
  throw Error("no calibration format that rastro reads", where,
              "EuRoC has 'sensor_type', KITTI 'P0', OpenCV and ROS 'camera_matrix', Kalibr 'cam0' at the top level");
}

}  // namespace

Calibration parse_calibration(std::string_view text, std::string_view where) {
  require_text(text, where);
  return calibration::looks_like_kitti(text) ? calibration::parse_kitti(text, where) : parse_yaml(text, where);
}

bool holds_camera(std::string_view text) {
  using namespace calibration;
  if (looks_like_kitti(text)) return true;
  try {
    const auto root = YamlFields::parse(text, "");
    return is_kalibr(root) || is_euroc(root) || is_opencv_or_ros(root);
  } catch (const Error&) {
  } catch (const YAML::Exception&) {
  }
  return true;  // Whoever reads it says what is wrong.
}

Calibration read_calibration(const std::string& path) {
  std::error_code not_there;
  if (const auto size = std::filesystem::file_size(path, not_there); !not_there) require_size(size, path);
  Calibration result = parse_calibration(read_text_file(path), path);
  const std::filesystem::path file(path);
  // EuRoC's file does not name its camera, only its folder does: mav0/cam1/sensor.yaml.
  if (result.format == "euroc" && file.filename() == "sensor.yaml" && file.has_parent_path())
    result.cameras.front().name = std::filesystem::weakly_canonical(file).parent_path().filename().string();
  return result;
}

std::optional<Camera> published_tum_camera(std::string_view name) {
  constexpr auto brown = Distortion::radial_tangential;
  // Of the Kinect's color camera (Ringaby and Forssen 2011, "Scan rectification for structured light range sensors with
  // rolling shutters"). That of freiburg3's Xtion is not published.
  constexpr double kinect_readout_s = 0.02611;
  if (name == "freiburg1")
    return Camera{
        640, 480, 517.3, 516.5, 318.6, 255.3, brown, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}, kinect_readout_s};
  if (name == "freiburg2")
    return Camera{
        640, 480, 520.9, 521.0, 325.1, 249.7, brown, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}, kinect_readout_s};
  if (name == "freiburg3") return Camera{640, 480, 535.4, 539.2, 320.1, 247.6, Distortion::none, {}};
  return std::nullopt;
}

}  // namespace rastro
