// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "rastro/camera/camera.h"

namespace rastro {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Camera euroc() {
  return {752,
          480,
          458.654,
          457.296,
          367.215,
          248.375,
          Distortion::radial_tangential,
          {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}};
}

TEST(CalibrationWarnings, NoneForAGoodCalibration) { EXPECT_THAT(calibration_warnings(euroc()), IsEmpty()); }

TEST(CalibrationWarnings, FocalLengthAgainstWidth) {
  Camera camera = euroc();
  camera.distortion = Distortion::none;
  camera.fx = camera.fy = 90.0;
  EXPECT_THAT(calibration_warnings(camera), ElementsAre(HasSubstr("field of view of 153 degrees")));
  camera.fx = camera.fy = 5000.0;
  EXPECT_THAT(calibration_warnings(camera), ElementsAre(HasSubstr("field of view of 8.6 degrees")));
}

TEST(CalibrationWarnings, UnequalFocalLengths) {
  Camera camera = euroc();
  camera.fy *= 1.3;
  EXPECT_THAT(calibration_warnings(camera), ElementsAre(HasSubstr("fx = 458.654 and fy = 594.485 differ")));
}

TEST(CalibrationWarnings, PrincipalPoint) {
  Camera camera = euroc();
  std::swap(camera.cx, camera.cy);
  EXPECT_THAT(calibration_warnings(camera), ElementsAre(HasSubstr("27 % of the size away from the center")));
  camera.cx = -5.0;
  EXPECT_THAT(calibration_warnings(camera), ElementsAre(HasSubstr("outside the 752x480 image")));
}

TEST(CalibrationWarnings, DistortionThatNoLensHas) {
  Camera camera = euroc();
  camera.coefficients = {5.0, 0.0, 0.0, 0.0};
  EXPECT_THAT(calibration_warnings(camera), ElementsAre(HasSubstr("larger than that of a lens")));
  camera.coefficients = {0.0, 0.0, 0.1, 0.0};
  EXPECT_THAT(calibration_warnings(camera), ElementsAre(HasSubstr("tangential coefficients up to 0.1")));
  camera.coefficients = {0.26, -0.95, -0.005, 0.003, 1.16};
  EXPECT_THAT(calibration_warnings(camera), ElementsAre());
}

TEST(CalibrationWarnings, DistortionThatFoldsBackInsideTheImage) {
  Camera camera = euroc();
  std::swap(camera.coefficients[0], camera.coefficients[1]);
  camera.coefficients[1] *= 3.0;
  EXPECT_THAT(calibration_warnings(camera), ElementsAre(HasSubstr("folds back inside the image")));
  camera.distortion = Distortion::equidistant;
  camera.coefficients = {-0.5, -0.5, 0.0, 0.0};
  EXPECT_THAT(calibration_warnings(camera), ElementsAre(HasSubstr("folds back inside the image")));
}

TEST(CalibrationWarnings, UnknownSizeSkipsTheChecksThatNeedIt) {
  Camera camera = euroc();
  camera.width = camera.height = 0;
  EXPECT_THAT(calibration_warnings(camera), IsEmpty());
  camera.fx = 0.0;
  EXPECT_THAT(calibration_warnings(camera), ElementsAre(HasSubstr("must be positive")));
}

}  // namespace
}  // namespace rastro
