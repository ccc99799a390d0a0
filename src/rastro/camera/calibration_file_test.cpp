// SPDX-License-Identifier: Apache-2.0
#include "rastro/camera/calibration_file.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "rastro/base/error.h"
#include "rastro/base/random.h"
#include "rastro/base/recorded_data_testing.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/math/math_testing.h"

namespace rastro {
namespace {

using rastro::testing::matrix_near;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

const std::string euroc = R"(# General sensor definitions.
sensor_type: camera
comment: VI-Sensor cam0 (MT9M034)
T_BS:
  cols: 4
  rows: 4
  data: [0.0, -1.0, 0.0, -0.02,
         1.0, 0.0, 0.0, -0.06,
         0.0, 0.0, 1.0, 0.01,
         0.0, 0.0, 0.0, 1.0]
rate_hz: 20
resolution: [752, 480]
camera_model: pinhole
intrinsics: [458.654, 457.296, 367.215, 248.375] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
)";

const std::string kitti = R"(P0: 7.0e+02 0.0 6.0e+02 0.0 0.0 7.0e+02 1.8e+02 0.0 0.0 0.0 1.0 0.0
P1: 7.0e+02 0.0 6.0e+02 -3.5e+02 0.0 7.0e+02 1.8e+02 0.0 0.0 0.0 1.0 0.0
P2: 7.0e+02 0.0 6.0e+02 4.2e+01 0.0 7.0e+02 1.8e+02 0.0 0.0 0.0 1.0 0.0
P3: 7.0e+02 0.0 6.0e+02 -3.4e+02 0.0 7.0e+02 1.8e+02 2.0 0.0 0.0 1.0 0.005
Tr: 1 0 0 0.1 0 1 0 0.2 0 0 1 0.3
)";

const std::string kitti_raw = R"(calib_time: 09-Jan-2012 13:57:47
corner_dist: 9.950000e-02
S_00: 1.392000e+03 5.120000e+02
K_00: 9.8e+02 0.0 6.9e+02 0.0 9.7e+02 2.4e+02 0.0 0.0 1.0
D_00: -3.7e-01 2.0e-01 1.3e-03 1.8e-03 -7.2e-02
R_00: 1.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 1.0
T_00: 0.0 0.0 0.0
S_rect_00: 1.242000e+03 3.750000e+02
R_rect_00: 1.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 1.0
P_rect_00: 7.2e+02 0.0 6.1e+02 0.0 0.0 7.2e+02 1.7e+02 0.0 0.0 0.0 1.0 0.0
S_01: 1.392000e+03 5.120000e+02
K_01: 9.9e+02 0.0 7.0e+02 0.0 9.8e+02 2.5e+02 0.0 0.0 1.0
D_01: -3.6e-01 1.9e-01 1.0e-03 1.0e-03 -7.0e-02
R_01: 1.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 1.0
T_01: -5.4e-01 0.0 0.0
S_rect_01: 1.242000e+03 3.750000e+02
R_rect_01: 1.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 1.0
P_rect_01: 7.2e+02 0.0 6.1e+02 -3.888e+02 0.0 7.2e+02 1.7e+02 0.0 0.0 0.0 1.0 0.0
)";

const std::string opencv = R"(%YAML:1.0
---
calibration_time: "Sat Jan  1 12:00:00 2022"
image_width: 640
image_height: 480
flags: 2
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 5.3591573396163199e+02, 0., 3.4228315473308373e+02, 0.,
       5.3591573396163199e+02, 2.3557082909788173e+02, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -2.6637260909660682e-01, -3.8588898922304653e-02,
       1.7831947042852964e-03, -2.8122100441115472e-04,
       2.3839153080878486e-01 ]
)";

const std::string ros = R"(image_width: 640
image_height: 480
camera_name: narrow_stereo/right
camera_matrix:
  rows: 3
  cols: 3
  data: [430.1, 0, 306.6, 0, 430.5, 227.2, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.337, 0.111, -0.0001, 0.0005, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [375.0, 0, 311.0, -37.5, 0, 375.0, 230.0, 0, 0, 0, 1, 0]
)";

const std::string kalibr = R"(cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.0270, 0.0116, -0.0123, 0.0044]
  distortion_model: equidistant
  intrinsics: [461.487, 460.152, 362.681, 246.067]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
  T_cam_imu:
  - [0.0, 1.0, 0.0, 0.06]
  - [-1.0, 0.0, 0.0, -0.02]
  - [0.0, 0.0, 1.0, 0.01]
  - [0.0, 0.0, 0.0, 1.0]
cam1:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.11]
  - [0.0, 1.0, 0.0, 0.001]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 0.0001, -0.00003]
  distortion_model: radtan
  intrinsics: [457.6, 456.1, 380.0, 255.2]
  resolution: [752, 480]
)";

const std::string transform = R"(calib_time: 15-Mar-2012 11:37:16
R: 0.0 -1.0 0.0 0.0 0.0 -1.0 1.0 0.0 0.0
T: -4.0e-03 -7.6e-02 -2.7e-01
delta_f: 0.0 0.0
)";

std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("the text does not contain " + from);
  return text.replace(at, from.size(), to);
}

Calibration parse(const std::string& text) { return parse_calibration(text, "calib"); }

/// The message of the error for `text`, or "no error".
std::string error_of(const std::string& text) {
  try {
    parse(text);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(CalibrationFile, Euroc) {
  for (const std::string& text : {euroc, "%YAML:1.0\n" + euroc, "%YAML 1.0\r\n---\n" + euroc}) {
    const Calibration read = parse(text);
    EXPECT_EQ(read.format, "euroc");
    EXPECT_THAT(read.warnings, IsEmpty());
    ASSERT_EQ(read.cameras.size(), 1U);
    const auto& [name, camera, body_from_camera, previous, rate, error] = read.cameras[0];
    EXPECT_EQ(camera.width, 752);
    EXPECT_EQ(camera.height, 480);
    EXPECT_EQ(camera.fx, 458.654);
    EXPECT_EQ(camera.fy, 457.296);
    EXPECT_EQ(camera.cx, 367.215);
    EXPECT_EQ(camera.cy, 248.375);
    EXPECT_EQ(camera.distortion, Distortion::radial_tangential);
    EXPECT_THAT(camera.coefficients,
                ElementsAre(-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0.0, 0.0, 0.0, 0.0));
    EXPECT_EQ(rate, 20.0);
    EXPECT_FALSE(error);
    EXPECT_FALSE(previous);
    ASSERT_TRUE(body_from_camera);
    EXPECT_THAT(*body_from_camera * Eigen::Vector3d(1, 2, 3), matrix_near(Eigen::Vector3d(-2.02, 0.94, 3.01), 1e-12));
  }
}

TEST(CalibrationFile, SaysHowWellItIsKnown) {
  const std::string opencv =
      "image_width: 640\nimage_height: 480\ncamera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, 0, 500, 240, 0, 0, "
      "1]}\n";
  for (const std::string& text : {euroc, opencv}) {
    EXPECT_EQ(parse(text + "calibration_error: 0.002\n").cameras[0].calibration_error, 0.002);
    EXPECT_EQ(parse(text + "calibration_error: 0.0\n").cameras[0].calibration_error, 0.0);
    EXPECT_FALSE(parse(text).cameras[0].calibration_error);
    EXPECT_THAT(error_of(text + "calibration_error: 2\n"), HasSubstr("is not a share"));
    EXPECT_THAT(error_of(text + "calibration_error: -0.1\n"), HasSubstr("is not a share"));
  }
}

TEST(CalibrationFile, KittiOdometry) {
  const Calibration read = parse(kitti);
  EXPECT_EQ(read.format, "kitti_odometry");
  EXPECT_THAT(read.warnings, IsEmpty());
  ASSERT_EQ(read.cameras.size(), 4U);
  EXPECT_EQ(read.cameras[1].name, "image_1");
  EXPECT_EQ(read.cameras[1].camera.fx, 700.0);
  EXPECT_EQ(read.cameras[1].camera.cy, 180.0);
  EXPECT_EQ(read.cameras[1].camera.width, 0);
  EXPECT_EQ(read.cameras[1].camera.distortion, Distortion::none);
  // The right camera is half a meter to the right.
  EXPECT_THAT(read.cameras[1].camera_from_previous->translation(), matrix_near(Eigen::Vector3d(-0.5, 0, 0), 1e-12));
  // K (I p + t) must equal P.
  const SE3 third_from_first = *read.cameras[3].camera_from_previous * *read.cameras[2].camera_from_previous *
                               *read.cameras[1].camera_from_previous;
  const auto pixel = read.cameras[3].camera.project(third_from_first * Eigen::Vector3d(1, 2, 10));
  const double w = 10.005;
  EXPECT_THAT(*pixel, matrix_near(Eigen::Vector2d((700 + 6000 - 340) / w, (1400 + 1800 + 2) / w), 1e-9));
}

TEST(CalibrationFile, KittiRaw) {
  const Calibration read = parse(kitti_raw);
  EXPECT_EQ(read.format, "kitti_raw");
  EXPECT_THAT(read.warnings, IsEmpty());
  ASSERT_EQ(read.cameras.size(), 4U);
  EXPECT_EQ(read.cameras[0].name, "image_00");
  EXPECT_EQ(read.cameras[0].camera.width, 1242);
  EXPECT_EQ(read.cameras[0].camera.fx, 720.0);
  EXPECT_EQ(read.cameras[0].camera.distortion, Distortion::none);
  EXPECT_THAT(read.cameras[1].camera_from_previous->translation(), matrix_near(Eigen::Vector3d(-0.54, 0, 0), 1e-12));
  EXPECT_EQ(read.cameras[3].name, "image_01_raw");
  EXPECT_EQ(read.cameras[3].camera.width, 1392);
  EXPECT_THAT(read.cameras[3].camera.coefficients, ElementsAre(-0.36, 0.19, 0.001, 0.001, -0.07, 0.0, 0.0, 0.0));
  EXPECT_FALSE(read.cameras[2].camera_from_previous);
  EXPECT_THAT(read.cameras[3].camera_from_previous->translation(), matrix_near(Eigen::Vector3d(-0.54, 0, 0), 1e-12));
}

TEST(CalibrationFile, KittiTransform) {
  const SE3 camera_from_velodyne = parse_kitti_transform(transform, "calib");
  EXPECT_THAT(camera_from_velodyne * Eigen::Vector3d(10, 1, 2),
              matrix_near(Eigen::Vector3d(-1.004, -2.076, 9.73), 1e-12));
  EXPECT_THROW(parse_kitti_transform(kitti, "calib"), Error);
  EXPECT_THAT(error_of(transform), HasSubstr("has no camera"));
}

TEST(CalibrationFile, OpenCv) {
  const Calibration read = parse(opencv);
  EXPECT_EQ(read.format, "opencv");
  const Camera& camera = read.cameras.at(0).camera;
  EXPECT_EQ(camera.width, 640);
  EXPECT_EQ(camera.fx, 5.3591573396163199e+02);
  EXPECT_EQ(camera.cy, 2.3557082909788173e+02);
  EXPECT_EQ(camera.coefficients[4], 2.3839153080878486e-01);
  const std::string four = with(with(opencv, "rows: 5", "rows: 4"), ",\n       2.3839153080878486e-01", "");
  EXPECT_EQ(parse(four).cameras.at(0).camera.distortion, Distortion::radial_tangential);
  const Calibration fisheye = parse(with(four, "flags: 2", "fisheye_model: 1"));
  EXPECT_EQ(fisheye.cameras.at(0).camera.distortion, Distortion::equidistant);
}

TEST(CalibrationFile, OpenCvStereoPair) {
  const std::string pair = with(with(opencv, "camera_matrix", "M1"), "distortion_coefficients", "D1") +
                           "M2: [[500, 0, 320], [0, 500, 240], [0, 0, 1]]\nD2: [0, 0, 0, 0]\n";
  const Calibration read = parse(pair);
  ASSERT_EQ(read.cameras.size(), 2U);
  EXPECT_EQ(read.cameras[0].name, "left");
  EXPECT_EQ(read.cameras[1].name, "right");
  EXPECT_EQ(read.cameras[1].camera.fx, 500.0);
  EXPECT_EQ(read.cameras[1].camera.distortion, Distortion::none);
}

TEST(CalibrationFile, RightPoseOfAnOpenCvPair) {
  const std::string pair = with(with(opencv, "camera_matrix", "M1"), "distortion_coefficients", "D1") +
                           "M2: [[500, 0, 320], [0, 500, 240], [0, 0, 1]]\nD2: [0, 0, 0, 0]\n"
                           "R: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nT: [-0.1, 0, 0]\n";
  const Calibration read = parse(pair);
  ASSERT_TRUE(read.cameras.at(1).camera_from_previous);
  EXPECT_EQ(read.cameras[1].camera_from_previous->translation().x(), -0.1);
  EXPECT_THAT(read.warnings, IsEmpty());
  EXPECT_THAT(parse(with(pair, "T: [-0.1", "T: [0.1")).warnings, Contains(HasSubstr("LEFT")));
  EXPECT_THAT(error_of(with(pair, "R: [1", "R: [2")), HasSubstr("R is not a rigid transform"));
}

const std::string own_depth =
    "depth_camera:\n  image_width: 512\n  image_height: 424\n  camera_matrix: [365, 0, 256, 0, 365, 206, 0, 0, 1]\n"
    "  distortion_model: plumb_bob\n  distortion_coefficients: [0.09, -0.27, 0, 0, 0.09]\n"
    "color_from_depth: [1, 0, 0, 0.052, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n";

TEST(CalibrationFile, DepthCameraBesideAColorCamera) {
  EXPECT_FALSE(parse(ros).depth);
  const Calibration read = parse(ros + own_depth);
  ASSERT_TRUE(read.depth);
  EXPECT_EQ(read.depth->depth_camera.height, 424);
  EXPECT_EQ(read.depth->depth_camera.coefficients[1], -0.27);
  EXPECT_EQ(read.depth->color_from_depth.translation().x(), 0.052);
  EXPECT_EQ(read.cameras.at(0).camera.fy, 430.5) << "of the color camera";
  EXPECT_THAT(error_of(ros + with(own_depth, "  image_width: 512\n", "")), HasSubstr("image_width"));
  EXPECT_THAT(error_of(ros + with(own_depth, "color_from_depth", "color_from_dept")), HasSubstr("color_from_depth"));
  EXPECT_THAT(error_of(ros + with(own_depth, "[1, 0, 0, 0.052", "[3, 0, 0, 0.052")), HasSubstr("rigid"));
}

TEST(CalibrationFile, ReadoutTimeOfARollingShutter) {
  EXPECT_EQ(parse(ros).cameras.at(0).camera.readout_s, 0.0);
  EXPECT_EQ(parse(ros + "readout_time: 0.026\n").cameras.at(0).camera.readout_s, 0.026);
  EXPECT_THAT(error_of(ros + "readout_time: 26\n"), HasSubstr("seconds"));
}

TEST(CalibrationFile, Ros) {
  const Calibration read = parse(ros);
  EXPECT_EQ(read.format, "ros");
  EXPECT_THAT(read.warnings, IsEmpty());
  EXPECT_EQ(read.cameras.at(0).name, "narrow_stereo/right");
  EXPECT_EQ(read.cameras[0].camera.fy, 430.5);
  EXPECT_EQ(read.cameras[0].camera.distortion, Distortion::radial_tangential);
  const std::string fisheye =
      with(with(with(ros, "plumb_bob", "equidistant"), "cols: 5", "cols: 4"), ", 0]\nrect", "]\nrect");
  EXPECT_EQ(parse(fisheye).cameras.at(0).camera.distortion, Distortion::equidistant);
}

TEST(CalibrationFile, RosRationalPolynomial) {
  const std::string rational = with(with(ros, "plumb_bob", "rational_polynomial"), "cols: 5", "cols: 8");
  const Calibration read = parse(with(rational, "0.0005, 0]", "0.0005, 0.01, 0, 0, 0]"));
  EXPECT_EQ(read.cameras.at(0).camera.coefficients[4], 0.01);
  EXPECT_EQ(read.cameras.at(0).camera.distortion, Distortion::radial_tangential);
  const Calibration whole = parse(with(rational, "0.0005, 0]", "0.0005, 0.01, 0.3, 0, -0.2]"));
  EXPECT_EQ(whole.cameras.at(0).camera.distortion, Distortion::rational);
  EXPECT_EQ(whole.cameras.at(0).camera.coefficients[7], -0.2);
  const std::string prism = with(with(ros, "plumb_bob", "rational_polynomial"), "cols: 5", "cols: 9");
  EXPECT_THAT(error_of(with(prism, "0.0005, 0]", "0.0005, 0.01, 0.3, 0, 0, 0.1]")),
              AllOf(HasSubstr("calib:9: "), HasSubstr("rational_polynomial"), HasSubstr("plumb_bob")));
}

TEST(CalibrationFile, Kalibr) {
  const Calibration read = parse(kalibr);
  EXPECT_EQ(read.format, "kalibr");
  EXPECT_THAT(read.warnings, IsEmpty());
  ASSERT_EQ(read.cameras.size(), 2U);
  EXPECT_EQ(read.cameras[0].camera.distortion, Distortion::equidistant);
  EXPECT_EQ(read.cameras[1].camera.distortion, Distortion::radial_tangential);
  // A point at the IMU is at T_cam_imu's translation in the camera.
  EXPECT_THAT(read.cameras[0].body_from_camera->inverse() * Eigen::Vector3d::Zero(),
              matrix_near(Eigen::Vector3d(0.06, -0.02, 0.01), 1e-12));
  EXPECT_FALSE(read.cameras[1].body_from_camera);
  EXPECT_THAT(read.cameras[1].camera_from_previous->translation(),
              matrix_near(Eigen::Vector3d(-0.11, 0.001, 0), 1e-12));
}

TEST(CalibrationFile, ABaselineOfTheWrongSignGivesAWarning) {
  const auto to_the_left = ElementsAre(HasSubstr("to the LEFT of"));
  EXPECT_THAT(parse(with(kitti, "-3.5e+02", "3.5e+02")).warnings, to_the_left);
  EXPECT_THAT(parse(with(kitti_raw, "-3.888e+02", "3.888e+02")).warnings, to_the_left);
  EXPECT_THAT(parse(with(kalibr, "-0.11", "0.11")).warnings, to_the_left);
  EXPECT_THAT(parse(with(ros, "-37.5", "37.5")).warnings, to_the_left);
}

TEST(CalibrationFile, NonRigidTransformsAreRefusedAndSlightlyNonRigidOnesGiveAWarning) {
  EXPECT_THAT(error_of(with(euroc, "0.0, -1.0, 0.0, -0.02", "0.0, -2.0, 0.0, -0.02")),
              AllOf(HasSubstr("calib:4: "), HasSubstr("T_BS is not a rigid transform")));
  EXPECT_THAT(error_of(with(euroc, "0.0, -1.0, 0.0, -0.02", "0.0, 1.0, 0.0, -0.02")), HasSubstr("T_BS is not a rigid"));
  EXPECT_THAT(error_of(with(euroc, "0.0, 0.0, 0.0, 1.0", "0.0, 0.0, 0.0, 0.0")), HasSubstr("T_BS is not a rigid"));
  EXPECT_THAT(parse(with(euroc, "0.0, -1.0, 0.0, -0.02", "0.0, -1.01, 0.0, -0.02")).warnings,
              ElementsAre(HasSubstr("T_BS is not quite a rotation")));
}

TEST(CalibrationFile, AnUnknownKeyIsReportedWithTheNearest) {
  EXPECT_THAT(error_of(with(euroc, "intrinsics", "intrinsic")),
              AllOf(HasSubstr("calib:"), HasSubstr("no key 'intrinsics'"), HasSubstr("'intrinsic'")));
  EXPECT_THAT(error_of(with(opencv, "camera_matrix", "camera_matrx")), HasSubstr("'camera_matrx'"));
  EXPECT_THAT(error_of(with(ros, "distortion_coefficients", "distortion_coeffs")), HasSubstr("'distortion_coeffs'"));
  EXPECT_THAT(error_of(with(kalibr, "distortion_model", "model")), HasSubstr("no key 'distortion_model'"));
  EXPECT_THAT(error_of(with(kitti_raw, "D_00", "E_00")), HasSubstr("no line 'D_00:'"));
  EXPECT_THAT(error_of(with(kitti_raw, "T_00: ", "T_00: 1.0 ")), HasSubstr("T_00 has 4 values, expected 3"));
  EXPECT_THAT(error_of("width of image: 3\n"), HasSubstr("no calibration format that rastro reads"));
}

struct Broken {
  const char* what;
  std::string text;
  const char* message;
};

TEST(CalibrationFile, EveryBrokenFileGivesOneLineWithCauseAndPosition) {
  const std::string shorter = with(kitti, " 0.0 0.0 0.0 1.0 0.0\nP1", "\nP1");
  const Broken all[] = {
      {"NaN", with(euroc, "458.654", ".nan"), "calib:14: intrinsics holds '.nan', not a finite number"},
      {"infinity", with(kalibr, "461.487", "inf"), "calib:6: intrinsics holds 'inf', not a finite number"},
      {"a word", with(ros, "430.1", "abc"), "calib:7: data holds 'abc', not a finite number"},
      {"NaN in KITTI", with(kitti, "-3.5e+02", "nan"), "calib:2: P1 holds 'nan', not a finite number"},
      {"overflow", with(kitti, "7.0e+02", "7.0e+999"), "calib:1: P0 holds '7.0e+999', not a finite number"},
      {"zero focal length", with(euroc, "458.654", "0"), "calib:14: focal length 0 px is not possible"},
      {"negative focal length", with(kitti, "P0: 7.0", "P0: -7.0"), "calib:1: focal length -700 px is not possible"},
      {"huge image", with(euroc, "[752, 480]", "[752000, 480]"), "calib:12: image size 752000x480 is not possible"},
      {"no image", with(kalibr, "[752, 480]", "[0, 480]"), "calib:7: image size 0x480 is not possible"},
      {"half a pixel", with(ros, "640", "640.5"), "calib:1: image size 640.5x480 is not possible"},
      {"too few intrinsics", with(euroc, ", 248.375", ""), "calib:14: intrinsics has 3 values, expected 4"},
      {"too few in a matrix", with(opencv, ", 0., 0., 1. ]", " ]"), "has 6 values, not rows times cols"},
      {"too few in a line", shorter, "calib:1: P0 has 7 values, expected 12"},
      {"a line twice", kitti + "P0: 1\n", "calib:6: the line 'P0:' occurs twice"},
      {"no colon", kitti + "hello\n", "calib:6: 'hello' is not of the form 'KEY: numbers'"},
      {"truncated", opencv.substr(0, opencv.find("2.3557")), "calib:"},
      {"other model", with(euroc, "radial-tangential", "fov"), "distortion model 'fov' is not supported"},
      {"a line break in a value", with(ros, "plumb_bob", "\"plumb\\nbob\""), "distortion model 'plumb\\x0abob' is not"},
      {"misspelled model", with(kalibr, "equidistant", "equidistand"), "did you mean 'equidistant'"},
      {"other camera model", with(kalibr, "pinhole", "omni"), "calib:3: camera_model is 'omni'"},
      {"wrong count", with(kalibr, "-0.0123, 0.0044", "-0.0123"), "distortion_coeffs has 3 values"},
      {"a sensor that is no camera", with(euroc, "camera\n", "imu\n"), "calib:2: sensor_type is 'imu', not 'camera'"},
      {"transposed matrix",
       with(ros, "[430.1, 0, 306.6, 0, 430.5, 227.2, 0, 0, 1]", "[430.1, 0, 0, 0, 430.5, 0, 306.6, 227.2, 1]"),
       "calib:4: camera_matrix is not [fx 0 cx"},
      {"not rectified", with(kitti, "P0: 7.0e+02 0.0", "P0: 7.0e+02 0.5"), "calib:1: P0 is not the projection"},
      {"a list", "- 1\n- 2\n", "calib: not a calibration"},
      {"a word only", "hello\n", "calib: not a calibration"},
      {"nothing", "", "calib: not a calibration"},
      {"tabs", "cam0:\n\tcamera_model: pinhole\n", "calib:"},
      {"binary", std::string("P0: \0 1", 7), "calib: not a text file"},
      {"open bracket", with(euroc, "480]", "480"), "calib:"},
      {"deep nesting", "camera_matrix: " + std::string(100000, '['), "calib:"},
      {"alias of itself", "camera_matrix: &a [*a, *a]\n", "calib:"},
      {"too large", "# " + std::string(5 << 20, 'x'), "calib: too large"},
  };
  for (const auto& [what, text, message] : all) {
    const std::string error = error_of(text);
    EXPECT_THAT(error, HasSubstr(message)) << what;
    EXPECT_THAT(error, Not(HasSubstr("\n"))) << what;
  }
}

/// However broken a file is, what is read from it can be used, or one line says why not. True if it was read.
bool reads_soundly_or_says_why(const std::string& text) {
  Calibration read;
  try {
    read = parse(text);
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), StartsWith("calib:")) << text;
    EXPECT_THAT(error.what(), Not(HasSubstr("\n"))) << text;
    return false;
  }
  EXPECT_FALSE(read.cameras.empty()) << text;
  for (const CalibratedCameraEntry& entry : read.cameras) {
    const Camera& camera = entry.camera;
    const bool usable = camera.fx > 0.0 && camera.fy > 0.0 && camera.width >= 0 && camera.height >= 0 &&
                        std::isfinite(camera.fx + camera.fy + camera.cx + camera.cy) &&
                        Eigen::Map<const Eigen::Array<double, 5, 1>>(camera.coefficients.data()).allFinite();
    EXPECT_TRUE(usable) << entry.name << "\n" << text;
    for (const auto& pose : {entry.body_from_camera, entry.camera_from_previous}) {
      if (!pose) continue;
      const Eigen::Matrix3d rotation = pose->rotation().matrix();
      EXPECT_THAT(rotation * rotation.transpose(), matrix_near(Eigen::Matrix3d::Identity(), 1e-9)) << text;
      EXPECT_TRUE(pose->translation().allFinite()) << text;
    }
    EXPECT_TRUE(!entry.rate_hz || (std::isfinite(*entry.rate_hz) && *entry.rate_hz > 0.0)) << text;
  }
  return true;
}

/// The original lens; or the same pinhole without distortion, as in a truncated file: OpenCV's and ROS's files need not
/// have one.
bool same_lens_or_no_distortion(const Camera& a, const Camera& b) {
  const bool pinhole =
      a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy;
  return pinhole &&
         (a.distortion == Distortion::none || (a.distortion == b.distortion && a.coefficients == b.coefficients));
}

TEST(CalibrationFile, TruncatedAnywhereItIsReadOrGivesAnError) {
  for (const std::string& text : {euroc, kitti, kitti_raw, opencv, ros, kalibr}) {
    const std::size_t step = 3, cuts = text.size() / step;
    std::size_t reads = 0;
    for (std::size_t length = 0; length < text.size(); length += step)
      reads += reads_soundly_or_says_why(text.substr(0, length)) ? 1 : 0;
    // A camera never comes from half a file. KITTI's raw files have one of two cameras after 68 % of their bytes.
    EXPECT_LT(reads, cuts / 3) << parse(text).format;
    EXPECT_TRUE(reads_soundly_or_says_why(text));
  }
}

/// Missing lines remove their cameras, or the whole file: no camera is made from the rest.
TEST(CalibrationFile, TruncatedAfterAnyLineACameraIsReadUnchangedOrNotAtAll) {
  for (const std::string& text : {euroc, kitti, kitti_raw, opencv, ros, kalibr}) {
    const Calibration whole = parse(text);
    for (std::size_t end = text.find('\n'); end + 1 < text.size(); end = text.find('\n', end + 1)) {
      const std::string cut = text.substr(0, end + 1);
      if (!reads_soundly_or_says_why(cut)) continue;
      const Calibration part = parse(cut);
      // The start of a ROS file is OpenCV's.
      EXPECT_TRUE(part.format == whole.format || whole.format == "ros") << cut;
      for (const CalibratedCameraEntry& entry : part.cameras) {
        const auto same = std::find_if(whole.cameras.begin(), whole.cameras.end(),
                                       [&](const CalibratedCameraEntry& other) { return other.name == entry.name; });
        ASSERT_NE(same, whole.cameras.end()) << entry.name << "\n" << cut;
        EXPECT_TRUE(same_lens_or_no_distortion(entry.camera, same->camera)) << entry.name << "\n" << cut;
      }
    }
  }
}

TEST(CalibrationFile, GarbledAnywhereItIsReadOrGivesAnError) {
  Random random(4);
  const std::string signs = "[]{}:,-#&*!|>'\"%@ \n\t0.9eEnx\x80";
  for (const std::string& text : {euroc, kitti, kitti_raw, opencv, ros, kalibr}) {
    int reads = 0;
    for (int i = 0; i < 300; ++i) {
      std::string garbled = text;
      for (int j = 0; j <= i % 3; ++j)
        garbled[random.below(static_cast<std::uint32_t>(garbled.size()))] =
            signs[random.below(static_cast<std::uint32_t>(signs.size()))];
      reads += reads_soundly_or_says_why(garbled) ? 1 : 0;
    }
    EXPECT_GT(reads, 5) << "none of these is ever read: " << parse(text).format;
    EXPECT_LT(reads, 295) << "none is ever refused: " << parse(text).format;
  }
}

TEST(CalibrationFile, FilesThatCannotBeRead) {
  EXPECT_THROW(read_calibration("/no/such/file.yaml"), Error);
  EXPECT_THROW(read_calibration(scratch_folder("folder")), Error);
}

TEST(CalibrationFile, AnEurocCameraIsNamedAfterItsFolder) {
  const auto folder = scratch_folder("cam7");
  std::ofstream(folder / "sensor.yaml") << euroc;
  EXPECT_EQ(read_calibration(folder / "sensor.yaml").cameras.at(0).name, "cam7");
}

TEST(CalibrationFile, PublishedTumCameras) {
  for (const char* name : {"freiburg1", "freiburg2", "freiburg3"}) {
    const auto camera = published_tum_camera(name);
    ASSERT_TRUE(camera) << name;
    EXPECT_THAT(calibration_warnings(*camera), IsEmpty()) << name;
  }
  EXPECT_EQ(published_tum_camera("freiburg1")->coefficients[4], 1.1633);
  EXPECT_FALSE(published_tum_camera("freiburg4"));
}

TEST(CalibrationFile, RealFilesReadWithoutAWarning) {
  if (!recorded_data("")) GTEST_SKIP() << no_recorded_data("");
  const auto data = recorded_data_path("");
  const std::pair<const char*, const char*> files[] = {{"euroc_v1_01_flight/mav0/cam0/sensor.yaml", "euroc"},
                                                       {"euroc_v1_01_still_stereo/mav0/cam1/sensor.yaml", "euroc"},
                                                       {"kitti_00/calib.txt", "kitti_odometry"},
                                                       {"kitti_residential/calib.txt", "kitti_odometry"},
                                                       {"chessboards/left_intrinsics.yml", "opencv"},
                                                       {"chessboards/intrinsics.yml", "opencv"}};
  for (const auto& [name, format] : files) {
    if (!std::filesystem::exists(data / name)) continue;
    const Calibration read = read_calibration(data / name);
    EXPECT_EQ(read.format, format) << name;
    EXPECT_THAT(read.warnings, IsEmpty()) << name;
    for (const auto& entry : read.cameras) EXPECT_THAT(calibration_warnings(entry.camera), IsEmpty()) << name;
  }
}

TEST(CalibrationFile, APairOfOpenCvNeedsNoFirstLine) {
  const auto pair = parse_calibration(
      "M1: [5, 0, 3.5, 0, 5, 2.5, 0, 0, 1]\nD1: [0, 0, 0, 0, 0]\nM2: [6, 0, 3.5, 0, 6, 2.5, 0, 0, 1]\n"
      "D2: [0, 0, 0, 0, 0]\nR: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nT: [-0.25, 0, 0]\n",
      "pair.yaml");
  EXPECT_EQ(pair.format, "opencv");
  ASSERT_EQ(pair.cameras.size(), 2u);
  EXPECT_EQ(pair.cameras[1].camera.fx, 6.0);
}

TEST(CalibrationFile, ZerosBehindTheCoefficientsOfAModelMeanNothing) {
  const auto camera_of = [](const std::string& model, const std::string& coefficients) {
    return parse_calibration(
               "image_width: 8\nimage_height: 6\ncamera_matrix: [5, 0, 3.5, 0, 5, 2.5, 0, 0, 1]\n"
               "distortion_model: " +
                   model + "\ndistortion_coefficients: [" + coefficients + "]\n",
               "padded.yaml")
        .cameras.front()
        .camera;
  };
  EXPECT_EQ(camera_of("plumb_bob", "0.1, 0.01, 0, 0, 0, 0, 0, 0").distortion, Distortion::radial_tangential);
  EXPECT_EQ(camera_of("plumb_bob", "0.1, 0.01, 0, 0, 0, 0, 0, 0").coefficients[0], 0.1);
  EXPECT_EQ(camera_of("equidistant", "0.1, 0.01, 0, 0, 0").distortion, Distortion::equidistant);
  EXPECT_THAT(error_of("distortion_model: plumb_bob\ncamera_matrix: [5, 0, 3.5, 0, 5, 2.5, 0, 0, 1]\n"
                       "distortion_coefficients: [0.1, 0.01, 0, 0, 0, 0.2]\n"),
              HasSubstr("has 6 values, which does not fit"));
}

TEST(CalibrationFile, HoldsACameraOrNot) {
  EXPECT_TRUE(holds_camera(euroc));
  EXPECT_TRUE(holds_camera(kitti));
  EXPECT_TRUE(holds_camera("camera_matrix: [1]\n")) << "a broken one";
  EXPECT_TRUE(holds_camera("camera: [")) << "no YAML at all";
  EXPECT_FALSE(holds_camera("depth_factor: 5000\ndepth_offset_m: 0.01\n"));
}

}  // namespace
}  // namespace rastro
