// SPDX-License-Identifier: Apache-2.0
#include "rastro/camera/write_calibration.h"

#include <gtest/gtest.h>

#include "rastro/base/error.h"

namespace rastro {
namespace {

std::vector<CalibratedCameraEntry> pair_of(Distortion distortion, double k3) {
  Camera left{640, 480, 501.25, 502.5, 321.125, 239.0 / 3.0 + 160.0, distortion, {-0.281, 0.0712, 1e-4, -2e-5, k3}};
  Camera right = left;
  right.fx = 499.0 + 1.0 / 7.0;
  right.coefficients[0] = -0.279;
  CalibratedCameraEntry first, second;
  first.name = "left";
  first.camera = left;
  first.calibration_error = 0.0012;
  second.name = "right";
  second.camera = right;
  second.camera_from_previous = SE3(SO3::exp({0.01, -0.02, 0.003}), {-0.06, 0.0011, 0.0004});
  return {first, second};
}

void expect_same(const Camera& read, const Camera& written) {
  EXPECT_EQ(read.width, written.width);
  EXPECT_EQ(read.height, written.height);
  EXPECT_EQ(read.readout_s, written.readout_s);
  EXPECT_EQ(read.fx, written.fx);
  EXPECT_EQ(read.fy, written.fy);
  EXPECT_EQ(read.cx, written.cx);
  EXPECT_EQ(read.cy, written.cy);
  EXPECT_EQ(read.distortion, written.distortion);
  EXPECT_EQ(read.coefficients, written.coefficients);
}

TEST(WriteCalibrationTest, TheRationalModelIsReadBackFromRosAndOpenCv) {
  auto pair = pair_of(Distortion::rational, 0.03);
  pair[0].camera.coefficients[5] = 0.2;
  pair[0].camera.coefficients[7] = -0.01;
  const Calibration ros = parse_calibration(ros_calibration_text(pair, 0), "ros.yaml");
  expect_same(ros.cameras.at(0).camera, pair[0].camera);
  const Calibration one = parse_calibration(opencv_calibration_text({pair[0]}), "opencv.yaml");
  expect_same(one.cameras.at(0).camera, pair[0].camera);
  EXPECT_FALSE(has_kalibr_form(pair));
  EXPECT_THROW(kalibr_calibration_text(pair), Error);
}

TEST(WriteCalibrationTest, ADepthCameraAndARollingShutterAreReadBack) {
  auto pair = pair_of(Distortion::radial_tangential, 0.03);
  pair[0].camera.readout_s = 0.026;
  DepthRegistration depth{pair[1].camera, *pair[1].camera_from_previous};
  for (const Distortion distortion : {Distortion::radial_tangential, Distortion::equidistant, Distortion::rational}) {
    depth.depth_camera.distortion = distortion;
    depth.depth_camera.coefficients[4] = distortion == Distortion::equidistant ? 0.0 : 0.03;
    depth.depth_camera.coefficients[7] = distortion == Distortion::rational ? 0.01 : 0.0;
    for (const std::string& color : {ros_calibration_text({pair[0]}, 0), opencv_calibration_text({pair[0]})}) {
      const Calibration read = parse_calibration(color + depth_registration_text(depth), "camera.yaml");
      expect_same(read.cameras.at(0).camera, pair[0].camera);
      ASSERT_TRUE(read.depth.has_value());
      expect_same(read.depth->depth_camera, depth.depth_camera);
      EXPECT_LT((read.depth->color_from_depth.inverse() * depth.color_from_depth).log().norm(), 1e-12);
    }
  }
}

TEST(WriteCalibrationTest, EveryFormatIsReadBackWithTheSameNumbers) {
  struct Case {
    Distortion distortion;
    double k3;
  };
  for (const auto& [distortion, k3] : {Case{Distortion::radial_tangential, 0.0},
                                       Case{Distortion::radial_tangential, 0.03}, Case{Distortion::equidistant, 0.0}}) {
    const auto pair = pair_of(distortion, k3);
    for (std::size_t camera = 0; camera < 2; ++camera) {
      const Calibration ros = parse_calibration(ros_calibration_text(pair, camera), "ros.yaml");
      EXPECT_EQ(ros.format, "ros");
      EXPECT_EQ(ros.cameras.at(0).name, pair[camera].name);
      EXPECT_TRUE(ros.warnings.empty());
      expect_same(ros.cameras.at(0).camera, pair[camera].camera);
    }
    const Calibration one = parse_calibration(opencv_calibration_text({pair[0]}), "opencv.yaml");
    expect_same(one.cameras.at(0).camera, pair[0].camera);
    EXPECT_EQ(one.cameras.at(0).calibration_error, 0.0012);
    const Calibration two = parse_calibration(opencv_calibration_text(pair), "opencv.yaml");
    ASSERT_EQ(two.cameras.size(), 2U);
    ASSERT_TRUE(two.cameras[1].camera_from_previous.has_value());
    EXPECT_LT((two.cameras[1].camera_from_previous->inverse() * *pair[1].camera_from_previous).log().norm(), 1e-12);
    for (std::size_t camera = 0; camera < 2; ++camera) expect_same(two.cameras[camera].camera, pair[camera].camera);
    ASSERT_EQ(has_kalibr_form(pair), k3 == 0.0);
    if (k3 != 0.0) {
      EXPECT_THROW(kalibr_calibration_text(pair), Error) << "radtan has exactly four coefficients";
      continue;
    }
    const Calibration chain = parse_calibration(kalibr_calibration_text(pair), "camchain.yaml");
    ASSERT_EQ(chain.cameras.size(), 2U);
    for (std::size_t camera = 0; camera < 2; ++camera) expect_same(chain.cameras[camera].camera, pair[camera].camera);
    ASSERT_TRUE(chain.cameras[1].camera_from_previous.has_value());
    const SE3 off = chain.cameras[1].camera_from_previous->inverse() * *pair[1].camera_from_previous;
    EXPECT_LT(off.log().norm(), 1e-12);
  }
}

}  // namespace
}  // namespace rastro
