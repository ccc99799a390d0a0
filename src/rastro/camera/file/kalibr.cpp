// SPDX-License-Identifier: Apache-2.0
// Kalibr's camchain (Furgale et al. 2013): cam0, cam1, ..., each relative to the previous one.
#include <fmt/format.h>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/camera/file/formats.h"
#include "rastro/camera/file/yaml_fields.h"

namespace rastro::calibration {
namespace {

constexpr int most_cameras = 100;

CalibratedCameraEntry parse_camera(const YamlFields& fields, const std::string& name,
                                   std::vector<std::string>& warnings) {
  if (fields.text({"camera_model"}) != "pinhole")
    fields.fail({"camera_model"},
                "is '" + one_line(fields.text({"camera_model"}), 40) + "', and only 'pinhole' is supported",
                "calibrate with pinhole-radtan or pinhole-equi");
  CalibratedCameraEntry entry;
  entry.name = name;
  set_intrinsics(entry.camera, fields);
  const auto size = fields.numbers({"resolution"}, 2);
  set_size(entry.camera, size[0], size[1], fields.at({"resolution"}));
  set_distortion(entry.camera, fields.text({"distortion_model"}), fields.numbers({"distortion_coeffs"}),
                 fields.at({"distortion_coeffs"}), "distortion_coeffs");
  const auto transform = [&](const char* key) {
    return rigid_transform(fields.matrix({key}, 4, 4), fmt::format("{} of {}", key, name), fields.at({key}), warnings);
  };
  if (fields.has({"T_cn_cnm1"})) entry.camera_from_previous = transform("T_cn_cnm1");
  if (fields.has({"T_cam_imu"})) entry.body_from_camera = transform("T_cam_imu").inverse();
  entry.rate_hz = optional_rate(fields);
  return entry;
}

}  // namespace

bool is_kalibr(const YamlFields& root) { return root.has_map({"cam0"}); }

Calibration parse_kalibr(const YamlFields& root) {
  Calibration result;
  result.format = "kalibr";
  for (int i = 0; i < most_cameras; ++i) {
    const std::string name = fmt::format("cam{}", i);
    if (!root.has({name.c_str()})) break;
    result.cameras.push_back(parse_camera(root.map({name.c_str()}), name, result.warnings));
    if (i == 0) {
      result.cameras.back().camera_from_previous.reset();
    } else if (const auto& chained = result.cameras.back().camera_from_previous) {
      check_baseline(*chained, result.cameras[result.cameras.size() - 2].name, name, result.warnings);
    }
  }
  return result;
}

}  // namespace rastro::calibration
