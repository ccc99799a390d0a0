// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/open.h"

namespace rastro {
namespace {

using testing::Contains;
using testing::HasSubstr;

/// cv::stereoCalibrate's, without OpenCV's first line; the right camera stands 0.25 m to the right.
constexpr const char* opencv_pair =
    "M1: [5, 0, 3.5, 0, 5, 2.5, 0, 0, 1]\nD1: [0, 0, 0, 0, 0]\nM2: [5.5, 0, 3.5, 0, 5.5, 2.5, 0, 0, 1]\n"
    "D2: [0, 0, 0, 0, 0]\nR: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nT: [-0.25, 0, 0]\n";
constexpr const char* kalibr_pair =
    "cam0:\n  camera_model: pinhole\n  intrinsics: [5, 5, 3.5, 2.5]\n  distortion_model: radtan\n"
    "  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [8, 6]\n"
    "cam1:\n  camera_model: pinhole\n  intrinsics: [5.5, 5.5, 3.5, 2.5]\n  distortion_model: radtan\n"
    "  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [8, 6]\n"
    "  T_cn_cnm1: [[1, 0, 0, -0.25], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n";

OpenOptions calibrated_by(const ScratchFolder& folder, const std::string& file) {
  OpenOptions options;
  options.want_right = true;
  options.calibration_file = folder.path(file);
  return options;
}

void expect_pair(const std::string& path, const OpenOptions& options, const std::string& warning) {
  SCOPED_TRACE(path + " " + options.calibration_file);
  const auto source = open(path, options);
  const auto& info = source->info();
  ASSERT_EQ(info.cameras.size(), 2u);
  EXPECT_EQ(info.cameras[0].camera->fx, 5.0);
  EXPECT_EQ(info.cameras[1].camera->fx, 5.5);
  ASSERT_TRUE(info.left_from_right);
  EXPECT_NEAR(info.left_from_right->translation().x(), 0.25, 1e-12);
  EXPECT_THAT(info.warnings, Contains(HasSubstr(warning)));
}

TEST(GivenCalibration, APairIsTakenInItsOrderWhereNoNameMatches) {
  const ScratchFolder files, euroc, kitti;
  files.write("pair.yaml", opencv_pair);
  files.write("chain.yaml", kalibr_pair);
  write_euroc(euroc, 2, 2);
  write_kitti(kitti, 2, 2);
  expect_pair(euroc.path(), calibrated_by(files, "pair.yaml"), "left, right is taken for cam0, cam1");
  expect_pair(kitti.path(), calibrated_by(files, "pair.yaml"), "left, right is taken for image_0, image_1");
  expect_pair(kitti.path(), calibrated_by(files, "chain.yaml"), "cam0, cam1 is taken for image_0, image_1");
}

TEST(GivenCalibration, OneCameraIsThatOfTheLeftImages) {
  const ScratchFolder files, euroc;
  files.write("one.yaml", "camera_matrix: [5, 0, 3.5, 0, 5, 2.5, 0, 0, 1]\ncamera_name: narrow\n");
  write_euroc(euroc, 2, 2);
  const auto source = open(euroc.path(), calibrated_by(files, "one.yaml"));
  ASSERT_EQ(source->info().cameras.size(), 2u);
  EXPECT_EQ(source->info().cameras[0].camera->fx, 5.0);
  EXPECT_FALSE(source->info().cameras[1].camera);
  EXPECT_FALSE(source->info().left_from_right);
  EXPECT_THAT(source->info().warnings, Contains(HasSubstr("one.yaml: no calibration for cam1")));
}

TEST(GivenCalibration, OneCameraOfSeveralMustBeNamed) {
  const ScratchFolder files, tum;
  files.write("pair.yaml", opencv_pair);
  write_tum(tum, 1);
  EXPECT_THAT(error_of([&] { open(tum.path(), calibrated_by(files, "pair.yaml")); }),
              HasSubstr("has left, right, but not rgb"));
}

}  // namespace
}  // namespace rastro
