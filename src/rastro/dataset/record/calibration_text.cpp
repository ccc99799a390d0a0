// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/record/calibration_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

namespace rastro {
namespace {

/// Four of the equidistant model, eight of the rational one, else five.
std::vector<double> coefficients_of(const Camera& camera) {
  const auto& all = camera.coefficients;
  if (camera.distortion == Distortion::rational) return {all.begin(), all.end()};
  return {all.begin(), all.begin() + (camera.distortion == Distortion::equidistant ? 4 : 5)};
}

std::string numbers(const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(fmt::format("{:.17g}", value));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

const char* model_of(const Camera& camera, const char* radial_tangential) {
  if (camera.distortion == Distortion::rational) return "rational_polynomial";
  return camera.distortion == Distortion::equidistant ? "equidistant" : radial_tangential;
}

/// Of a rolling shutter.
std::string readout_line(const Camera& camera) {
  return camera.readout_s > 0.0 ? fmt::format("readout_time: {:.17g}\n", camera.readout_s) : "";
}

}  // namespace

std::string euroc_calibration_text(const CalibratedCamera& calibrated, const SE3& body_from_camera) {
  const Camera& camera = *calibrated.camera;
  const Eigen::Matrix4d matrix = body_from_camera.matrix();
  std::vector<double> rows;
  for (int i = 0; i < 16; ++i) rows.push_back(matrix(i / 4, i % 4));
  return fmt::format(
             "sensor_type: camera\n# Sensor extrinsics wrt. the body-frame.\nT_BS:\n  cols: 4\n  rows: 4\n  data: {}\n"
             "resolution: [{}, {}]\ncamera_model: pinhole\nintrinsics: {} #fu, fv, cu, cv\n"
             "distortion_model: {}\ndistortion_coefficients: {}\ncalibration_error: {:.17g}\n",
             numbers(rows), camera.width, camera.height, numbers({camera.fx, camera.fy, camera.cx, camera.cy}),
             model_of(camera, "radial-tangential"), numbers(coefficients_of(camera)), calibrated.calibration_error) +
         readout_line(camera);
}

std::string opencv_calibration_text(const CalibratedCamera& calibrated) {
  const Camera& camera = *calibrated.camera;
  const std::vector<double> coefficients = coefficients_of(camera);
  return fmt::format(
             "image_width: {}\nimage_height: {}\ncamera_name: rgb\n"
             "camera_matrix:\n  rows: 3\n  cols: 3\n  data: {}\n"
             "distortion_model: {}\ndistortion_coefficients:\n  rows: 1\n  cols: {}\n  data: {}\ncalibration_error: "
             "{:.17g}\n",
             camera.width, camera.height,
             numbers({camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0}),
             model_of(camera, "plumb_bob"), coefficients.size(), numbers(coefficients), calibrated.calibration_error) +
         readout_line(camera);
}

}  // namespace rastro
