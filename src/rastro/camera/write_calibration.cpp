// SPDX-License-Identifier: Apache-2.0
#include "rastro/camera/write_calibration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/camera/stereo_rectification.h"

namespace rastro {
namespace {

constexpr std::size_t kalibr_coefficients = 4;  ///< Of radtan and of equidistant.

std::string numbers(const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(fmt::format("{:.17g}", value));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

std::vector<double> row_by_row(const Eigen::MatrixXd& matrix) {
  std::vector<double> values;
  for (Eigen::Index row = 0; row < matrix.rows(); ++row)
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) values.push_back(matrix(row, column));
  return values;
}

std::vector<double> coefficients_to_write(const Camera& camera) {
  const auto& all = camera.coefficients;
  const auto count = static_cast<std::ptrdiff_t>(std::max<std::size_t>(4, camera.coefficient_count()));
  return {all.begin(), all.begin() + count};
}

const char* ros_model(Distortion distortion) {
  if (distortion == Distortion::rational) return "rational_polynomial";
  return distortion == Distortion::equidistant ? "equidistant" : "plumb_bob";
}

Eigen::Matrix3d matrix_of(const Camera& camera) {
  Eigen::Matrix3d matrix;
  matrix << camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0;
  return matrix;
}

std::string ros_matrix(const char* name, const Eigen::MatrixXd& matrix) {
  return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: {}\n", name, matrix.rows(), matrix.cols(),
                     numbers(row_by_row(matrix)));
}

std::string opencv_matrix(const char* name, const Eigen::MatrixXd& matrix) {
  return fmt::format("{}: !!opencv-matrix\n  rows: {}\n  cols: {}\n  dt: d\n  data: {}\n", name, matrix.rows(),
                     matrix.cols(), numbers(row_by_row(matrix)));
}

Eigen::MatrixXd as_row(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::RowVectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

struct Rectified {
  Eigen::Matrix3d rectification = Eigen::Matrix3d::Identity();
  Eigen::MatrixXd projection = Eigen::MatrixXd::Zero(3, 4);
};

Rectified rectified(const std::vector<CalibratedCameraEntry>& pair, std::size_t camera) {
  Rectified result;
  if (pair.size() == 2 && pair[1].camera_from_previous) {
    const SE3 left_from_right = pair[1].camera_from_previous->inverse();
    if (const auto stereo = rectify_stereo(pair[0].camera, pair[1].camera, left_from_right)) {
      SO3 rectified_from_camera = stereo->left_from_rectified.inverse();
      if (camera == 1) rectified_from_camera = rectified_from_camera * left_from_right.rotation();
      result.rectification = rectified_from_camera.matrix();
      result.projection.leftCols<3>() = matrix_of(stereo->camera);
      if (camera == 1) result.projection(0, 3) = -stereo->camera.fx * stereo->baseline;
      return result;
    }
  }
  result.projection.leftCols<3>() = matrix_of(undistorted_camera(pair[camera].camera, 0.0));
  return result;
}

/// rastro's own keys.
std::string own_lines(const CalibratedCameraEntry& entry) {
  std::string lines;
  if (entry.calibration_error) lines += fmt::format("calibration_error: {:.6g}\n", *entry.calibration_error);
  if (entry.camera.readout_s > 0.0) lines += fmt::format("readout_time: {:.17g}\n", entry.camera.readout_s);
  return lines;
}

}  // namespace

std::string ros_calibration_text(const std::vector<CalibratedCameraEntry>& pair, std::size_t camera) {
  RASTRO_CHECK(camera < pair.size(), "a calibration to write has this camera");
  const Camera& of = pair[camera].camera;
  const Rectified view = rectified(pair, camera);
  return fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\n", of.width, of.height, pair[camera].name) +
         ros_matrix("camera_matrix", matrix_of(of)) + fmt::format("distortion_model: {}\n", ros_model(of.distortion)) +
         ros_matrix("distortion_coefficients", as_row(coefficients_to_write(of))) +
         ros_matrix("rectification_matrix", view.rectification) + ros_matrix("projection_matrix", view.projection) +
         own_lines(pair[camera]);
}

std::string depth_registration_text(const DepthRegistration& depth) {
  const Camera& camera = depth.depth_camera;
  const auto matrix = [](const char* name, const Eigen::MatrixXd& values) {
    return fmt::format("  {}: {{rows: {}, cols: {}, data: {}}}\n", name, values.rows(), values.cols(),
                       numbers(row_by_row(values)));
  };
  return fmt::format("depth_camera:\n  image_width: {}\n  image_height: {}\n", camera.width, camera.height) +
         matrix("camera_matrix", matrix_of(camera)) +
         fmt::format("  distortion_model: {}\n", ros_model(camera.distortion)) +
         matrix("distortion_coefficients", as_row(coefficients_to_write(camera))) +
         fmt::format("color_from_depth: {}\n", numbers(row_by_row(depth.color_from_depth.matrix())));
}

std::string opencv_calibration_text(const std::vector<CalibratedCameraEntry>& cameras) {
  RASTRO_CHECK(!cameras.empty() && cameras.size() <= 2, "OpenCV's files have one camera or two");
  const Camera& first = cameras.front().camera;
  std::string text = fmt::format("%YAML:1.0\n---\nimage_width: {}\nimage_height: {}\n", first.width, first.height);
  if (first.distortion == Distortion::equidistant) text += "fisheye_model: 1\n";
  if (cameras.size() == 1)
    return text + opencv_matrix("camera_matrix", matrix_of(first)) +
           opencv_matrix("distortion_coefficients", as_row(coefficients_to_write(first)).transpose()) +
           own_lines(cameras.front());
  const Camera& second = cameras.back().camera;
  text += opencv_matrix("M1", matrix_of(first)) + opencv_matrix("D1", as_row(coefficients_to_write(first))) +
          opencv_matrix("M2", matrix_of(second)) + opencv_matrix("D2", as_row(coefficients_to_write(second)));
  if (const auto& right_from_left = cameras.back().camera_from_previous)
    text +=
        opencv_matrix("R", right_from_left->rotation().matrix()) + opencv_matrix("T", right_from_left->translation());
  return text + own_lines(cameras.front());
}

bool has_kalibr_form(const std::vector<CalibratedCameraEntry>& cameras) {
  return std::all_of(cameras.begin(), cameras.end(), [](const CalibratedCameraEntry& each) {
    return coefficients_to_write(each.camera).size() == kalibr_coefficients;
  });
}

std::string kalibr_calibration_text(const std::vector<CalibratedCameraEntry>& cameras) {
  std::string text;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Camera& camera = cameras[i].camera;
    const std::vector<double> coefficients = coefficients_to_write(camera);
    if (coefficients.size() != kalibr_coefficients)
      throw Error(fmt::format("has {} distortion coefficients, Kalibr's models have {}", coefficients.size(),
                              kalibr_coefficients),
                  cameras[i].name, "calibrate with --model pinhole4 or equidistant for Kalibr");
    text += fmt::format(
        "cam{}:\n  camera_model: pinhole\n  distortion_model: {}\n  distortion_coeffs: {}\n  intrinsics: {}\n"
        "  resolution: [{}, {}]\n  rostopic: /{}/image_raw\n",
        i, camera.distortion == Distortion::equidistant ? "equidistant" : "radtan", numbers(coefficients),
        numbers({camera.fx, camera.fy, camera.cx, camera.cy}), camera.width, camera.height, cameras[i].name);
    if (i == 0 || !cameras[i].camera_from_previous) continue;
    text += "  T_cn_cnm1:\n";
    const Eigen::MatrixXd matrix = cameras[i].camera_from_previous->matrix();
    for (Eigen::Index row = 0; row < 4; ++row) text += fmt::format("  - {}\n", numbers(row_by_row(matrix.row(row))));
  }
  return text;
}

}  // namespace rastro
