// SPDX-License-Identifier: Apache-2.0
// YAML of OpenCV's FileStorage as its calibration samples write it, and of ROS's camera_calibration
// (camera_info_manager), which uses the same keys and adds the model's name, rectification and projection. Printed
// CameraInfo messages too.
#include <Eigen/LU>

#include "rastro/base/error.h"
#include "rastro/camera/file/formats.h"
#include "rastro/camera/file/yaml_fields.h"

namespace rastro::calibration {
namespace {

constexpr Names matrix_keys = {"camera_matrix", "Camera_Matrix", "cameraMatrix", "K", "k"};
constexpr Names distortion_keys = {
    "distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "dist_coeffs", "D", "d"};
constexpr Names width_keys = {"image_width", "image_Width", "width"};
constexpr Names height_keys = {"image_height", "image_Height", "height"};
constexpr Names size_keys = {"image_size", "imageSize"};

void set_camera_matrix(Camera& camera, const YamlFields& fields, Names keys) {
  const Eigen::Matrix3d matrix = fields.matrix(keys, 3, 3);
  const bool triangular = matrix(1, 0) == 0.0 && matrix.row(2) == Eigen::RowVector3d(0.0, 0.0, 1.0);
  if (!triangular) fields.fail(keys, "is not [fx 0 cx; 0 fy cy; 0 0 1]", "is it written row by row?");
  if (matrix(0, 1) != 0.0) fields.fail(keys, "has a skew, which is not supported", "");
  camera.fx = matrix(0, 0);
  camera.fy = matrix(1, 1);
  camera.cx = matrix(0, 2);
  camera.cy = matrix(1, 2);
}

void set_image_size(Camera& camera, const YamlFields& fields) {
  if (fields.has(width_keys) || fields.has(height_keys)) {
    set_size(camera, fields.number(width_keys), fields.number(height_keys), fields.at(width_keys));
  } else if (fields.has(size_keys)) {
    const auto size = fields.numbers(size_keys, 2);
    set_size(camera, size[0], size[1], fields.at(size_keys));
  }
}

/// OpenCV's files do not name the model; the number of coefficients, or a flag, tells it.
std::string distortion_model(const YamlFields& fields, std::size_t count) {
  static constexpr Names keys = {"distortion_model"};
  if (fields.has(keys)) {
    const std::string name = fields.text(keys);
    if (!name.empty() && name != "~") return name;
  }
  if (fields.has({"fisheye_model"}) && fields.number({"fisheye_model"}) != 0.0) return "fisheye";
  return count > 5 ? "rational_polynomial" : "radtan";
}

CalibratedCameraEntry parse_camera(const YamlFields& fields, Names matrix, Names distortion) {
  CalibratedCameraEntry entry;
  set_camera_matrix(entry.camera, fields, matrix);
  set_image_size(entry.camera, fields);
  const auto coefficients = fields.has(distortion) ? fields.numbers(distortion) : std::vector<double>();
  if (!fields.has(distortion) && fields.has({"distortion_model"})) fields.fail_missing(distortion);
  set_distortion(entry.camera, distortion_model(fields, coefficients.size()), coefficients, fields.at(distortion),
                 *distortion.begin());
  require_usable(entry.camera, fields.at(matrix));
  entry.calibration_error = optional_calibration_error(fields);
  set_readout_time(entry.camera, fields);
  return entry;
}

void check_projection(const YamlFields& fields, std::vector<std::string>& warnings) {
  static constexpr Names keys = {"projection_matrix", "P", "p"};
  if (!fields.has(keys)) return;
  const Eigen::MatrixXd projection = fields.matrix(keys, 3, 4);
  // ROS: P(0, 3) = -fx * baseline of the right camera, 0 of the left one.
  if (projection(0, 0) <= 0.0 || projection(0, 3) <= 0.0) return;
  const SE3 from_left(SO3(), {projection(0, 3) / projection(0, 0), 0.0, 0.0});
  check_baseline(from_left, "the first camera", "the camera of this projection_matrix", warnings);
}

/// R and T as cv::stereoCalibrate gives them, where a file holds them beside both cameras.
void set_right_pose(Calibration& result, const YamlFields& root) {
  static constexpr Names rotation_key = {"R"}, translation_key = {"T"};
  if (!root.has(rotation_key) || !root.has(translation_key)) return;
  Eigen::MatrixXd right_from_left = Eigen::MatrixXd::Identity(4, 4);
  right_from_left.topLeftCorner(3, 3) = root.matrix(rotation_key, 3, 3);
  right_from_left.topRightCorner(3, 1) = root.matrix(translation_key, 3, 1);
  result.cameras.back().camera_from_previous =
      rigid_transform(right_from_left, *rotation_key.begin(), root.at(rotation_key), result.warnings);
  check_baseline(*result.cameras.back().camera_from_previous, "left", "right", result.warnings);
}

}  // namespace

std::optional<DepthRegistration> optional_depth_registration(const YamlFields& root,
                                                             std::vector<std::string>& warnings) {
  static constexpr Names camera_key = {"depth_camera"}, pose_key = {"color_from_depth"};
  if (!root.has(camera_key)) return std::nullopt;
  const YamlFields fields = root.map(camera_key);
  DepthRegistration depth;
  depth.depth_camera = parse_camera(fields, matrix_keys, distortion_keys).camera;
  if (depth.depth_camera.width <= 0) fields.fail_missing(width_keys);
  depth.color_from_depth = rigid_transform(root.matrix(pose_key, 4, 4), *pose_key.begin(), root.at(pose_key), warnings);
  return depth;
}

bool is_opencv_or_ros(const YamlFields& root) {
  return root.has(matrix_keys) || root.has({"M1"}) || root.has(distortion_keys) || root.has(width_keys);
}

Calibration parse_opencv_or_ros(const YamlFields& root) {
  Calibration result;
  result.format = root.has({"distortion_model"}) ? "ros" : "opencv";
  if (root.has({"M1"})) {
    result.cameras.push_back(parse_camera(root, {"M1"}, {"D1"}));
    result.cameras.back().name = "left";
    if (!root.has({"M2"})) return result;
    result.cameras.push_back(parse_camera(root, {"M2"}, {"D2"}));
    result.cameras.back().name = "right";
    set_right_pose(result, root);
    return result;
  }
  result.cameras.push_back(parse_camera(root, matrix_keys, distortion_keys));
  result.cameras.back().name = root.has({"camera_name"}) ? root.text({"camera_name"}) : "camera";
  result.depth = optional_depth_registration(root, result.warnings);
  check_projection(root, result.warnings);
  return result;
}

}  // namespace rastro::calibration
