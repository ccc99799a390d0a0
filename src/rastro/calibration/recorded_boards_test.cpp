// SPDX-License-Identifier: Apache-2.0
// The chessboards of OpenCV's samples, against the calibrations that lie beside them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "rastro/base/recorded_data_testing.h"
#include "rastro/calibration/board_detector.h"
#include "rastro/calibration/report.h"
#include "rastro/camera/calibration_file.h"

namespace rastro {
namespace {

const Board board{9, 6, 0.025};

/// Corners of every image of one side ("left", "right") or both.
CalibrationInput chessboards(const std::string& folder, const std::vector<std::string>& sides) {
  CalibrationInput input;
  input.board = board.points();
  input.width = 640;
  input.height = 480;
  input.stereo = sides.size() > 1;
  for (int number = 1; number <= 14; ++number) {
    if (number == 10) continue;
    const std::string name = (number < 10 ? "0" : "") + std::to_string(number) + ".jpg";
    for (int camera = 0; camera < static_cast<int>(sides.size()); ++camera) {
      const cv::Mat image =
          cv::imread(folder + "/" + sides[static_cast<std::size_t>(camera)] + name, cv::IMREAD_GRAYSCALE);
      const auto corners =
          detect_board({image.data, image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step)}, board);
      if (!corners) continue;
      input.views.push_back({static_cast<int>(input.frames.size()), camera, corners->corners, corners->pixels});
    }
    input.frames.push_back(name);
  }
  return input;
}

/// RMS of the same views with a lens that is given, whose poses alone are estimated.
double rms_with(const CameraCalibration& ours, const std::string& file) {
  const Camera camera = read_calibration(file).cameras.at(0).camera;
  BoardProblem problem = ours.solution.problem;
  Lens& lens = problem.lenses[0];
  lens = undistorted_lens(LensModel::pinhole_5, camera.fx, {camera.cx, camera.cy});
  lens.parameters[1] = camera.fy;
  for (int k = 0; k < 5; ++k) lens.parameters[4 + k] = camera.coefficients[static_cast<std::size_t>(k)];
  BoardAdjustmentOptions poses_only;
  poses_only.free_lenses = false;
  return adjust_boards(problem, poses_only).rms_px();
}

TEST(RecordedBoardsTest, LeftCameraFitsNoWorseThanOpenCvs) {
  const auto found = recorded_data("chessboards");
  if (!found) GTEST_SKIP() << no_recorded_data("chessboards");
  const std::string folder = found->string();
  const CalibrationInput input = chessboards(folder, {"left"});
  EXPECT_EQ(input.views.size(), 13U);
  const CameraCalibration calibration = calibrate_camera(input);
  CalibrationReport report{input, calibration, {judge_calibration(calibration, 0, 640, 480)}, 13, 13};
  std::printf("%s", calibration_summary(report).c_str());
  EXPECT_LE(calibration.solution.rms_px(), rms_with(calibration, folder + "/left_intrinsics.yml"));
  EXPECT_LT(calibration.solution.rms_px(), 0.19);
}

TEST(RecordedBoardsTest, PairHasTheBaselineThatBothCamerasAgreeOn) {
  const auto found = recorded_data("chessboards");
  if (!found) GTEST_SKIP() << no_recorded_data("chessboards");
  const std::string folder = found->string();
  const CalibrationInput input = chessboards(folder, {"left", "right"});
  EXPECT_EQ(input.views.size(), 26U);
  const CameraCalibration calibration = calibrate_camera(input);
  CalibrationReport report{input, calibration, {}, 26, 26};
  for (std::size_t camera = 0; camera < 2; ++camera)
    report.trust.push_back(judge_calibration(calibration, camera, 640, 480));
  std::printf("%s", calibration_summary(report).c_str());
  // No board comes nearer than a sixth of the image to these edges.
  EXPECT_THAT(report.trust[0].coverage.missing, testing::ElementsAre("the left edge", "upper left"));
  EXPECT_THAT(report.trust[1].coverage.missing, testing::ElementsAre("the right edge", "upper right"));
  EXPECT_LT(calibration.solution.rms_px(), 0.25);
  EXPECT_NEAR(calibration.solution.problem.right_from_left.inverse().translation().norm(), 0.0833, 0.002);
}

}  // namespace
}  // namespace rastro
