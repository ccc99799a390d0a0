// SPDX-License-Identifier: Apache-2.0
// EuRoC's sensor.yaml (Burri et al. 2016). ASL's own and many other data sets write it, with and without "%YAML:1.0".
#include <cmath>

#include "rastro/base/text.h"
#include "rastro/camera/file/formats.h"
#include "rastro/camera/file/yaml_fields.h"

namespace rastro::calibration {

bool is_euroc(const YamlFields& root) { return root.has({"sensor_type", "T_BS"}); }

Calibration parse_euroc(const YamlFields& root) {
  if (root.has({"sensor_type"}) && root.text({"sensor_type"}) != "camera")
    root.fail({"sensor_type"}, "is '" + one_line(root.text({"sensor_type"}), 40) + "', not 'camera'",
              "name the camera's own sensor.yaml");
  if (root.has({"camera_model"}) && root.text({"camera_model"}) != "pinhole")
    root.fail({"camera_model"}, "is not 'pinhole', the only one supported", "");
  Calibration result;
  result.format = "euroc";
  CalibratedCameraEntry entry;
  entry.name = "cam0";
  set_intrinsics(entry.camera, root);
  const auto size = root.numbers({"resolution"}, 2);
  set_size(entry.camera, size[0], size[1], root.at({"resolution"}));
  set_distortion(entry.camera, root.text({"distortion_model"}), root.numbers({"distortion_coefficients"}),
                 root.at({"distortion_coefficients"}), "distortion_coefficients");
  if (root.has({"T_BS"}))
    entry.body_from_camera = rigid_transform(root.matrix({"T_BS"}, 4, 4), "T_BS", root.at({"T_BS"}), result.warnings);
  entry.rate_hz = optional_rate(root);
  entry.calibration_error = optional_calibration_error(root);
  set_readout_time(entry.camera, root);
  result.cameras.push_back(std::move(entry));
  return result;
}

}  // namespace rastro::calibration
