// SPDX-License-Identifier: Apache-2.0
// Calibrations with something wrong: it must be named.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/calibration/boards_testing.h"
#include "rastro/calibration/report.h"

namespace rastro {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

CalibrationTrust judged(const CalibrationInput& input, const CalibrationOptions& options = {}) {
  return judge_calibration(calibrate_camera(input, options), 0, input.width, input.height);
}

std::string told(const CalibrationTrust& trust) {
  std::string text;
  for (const std::string& line : trust.doubts) text += line + "\n";
  return text;
}

/// Many views all over the image.
GeneratedOptions enough() { return {.seed = 3, .frames = 40}; }

TEST(CalibrationFaultsTest, GoodBoardsAreNotDoubted) {
  for (const LensModel model : {LensModel::pinhole_4, LensModel::pinhole_5, LensModel::equidistant}) {
    GeneratedOptions options = enough();
    options.model = model;
    const GeneratedBoards made = generate_boards(options);
    const CameraCalibration calibration = calibrate_camera(made.input);
    const CalibrationTrust trust = judge_calibration(calibration, 0, 640, 480);
    if (model != LensModel::equidistant) {  // its wide corners of the image are seen by few boards, and that is said
      EXPECT_EQ(told(trust), "") << lens_model_name(model);
      EXPECT_EQ(trust.trust, Trust::good);
    }
    EXPECT_TRUE(trust.halves.done && trust.halves.agree);
    EXPECT_NEAR(calibration.holdout_px, calibration.solution.rms_px(), 0.03);
    if (model == LensModel::equidistant) {
      EXPECT_EQ(calibration.solution.problem.lenses[0].model, model);
    }
  }
}

TEST(CalibrationFaultsTest, BadFramesAreNamed) {
  GeneratedBoards made = generate_boards(enough());
  Random random(5);
  for (const std::size_t bad : {4U, 17U})
    for (Eigen::Vector2d& pixel : made.input.views[bad].pixels)
      pixel += 6.0 * Eigen::Vector2d(random.normal(), random.normal());
  made.input.views[9].pixels[11] += Eigen::Vector2d(8.0, -5.0);
  const CameraCalibration calibration = calibrate_camera(made.input);
  ASSERT_EQ(calibration.frames_left_out.size(), 2U);
  EXPECT_EQ(calibration.frames_left_out[0].frame, 4);
  EXPECT_EQ(calibration.frames_left_out[1].frame, 17);
  EXPECT_EQ(calibration.corners_left_out, 1);
  EXPECT_NEAR(calibration.solution.noise_px(), 0.2, 0.01);
}

TEST(CalibrationFaultsTest, BowedBoardIsNamedAndTakenOut) {
  GeneratedOptions options = enough();
  options.shape = {0.0015, -0.0008, 0.0};
  const GeneratedBoards made = generate_boards(options);
  const CameraCalibration calibration = calibrate_camera(made.input);
  EXPECT_THAT(told(judge_calibration(calibration, 0, 640, 480)), HasSubstr("board is not flat"));
  EXPECT_FALSE(calibration.shape.stretched);
  EXPECT_NEAR(calibration.shape.bow_x_m, 0.0015, 5.0 * calibration.shape.bow_sigma_m);
  EXPECT_NEAR(calibration.solution.problem.lenses[0].parameters[0], made.truth.lenses[0].parameters[0],
              4.0 * calibration.lens_sigmas(0)[0]);
}

TEST(CalibrationFaultsTest, SquaresHigherThanWideAreNamed) {
  GeneratedOptions options = enough();
  options.frames = 24;
  options.shape = {0.0, 0.0, 0.03};
  const GeneratedBoards made = generate_boards(options);
  const CameraCalibration calibration = calibrate_camera(made.input);
  EXPECT_THAT(told(judge_calibration(calibration, 0, 640, 480)), HasSubstr("squares are not square"));
  EXPECT_NEAR(calibration.shape.stretch_y, 0.03, 5.0 * calibration.shape.stretch_sigma);
  EXPECT_NEAR(calibration.solution.problem.lenses[0].parameters[1], made.truth.lenses[0].parameters[1],
              4.0 * calibration.lens_sigmas(0)[1]);
}

TEST(CalibrationFaultsTest, ModelThatIsTooSimpleIsNamedAndCostsNoGoodFrame) {
  GeneratedOptions options = enough();
  options.frames = 24;
  options.model = LensModel::pinhole_8;
  const GeneratedBoards made = generate_boards(options);
  const CameraCalibration calibration = calibrate_camera(made.input, {.model = LensModel::pinhole_4});
  EXPECT_THAT(told(judge_calibration(calibration, 0, 640, 480)), HasSubstr("model is too simple"));
  EXPECT_EQ(calibration.best_model, LensModel::pinhole_8);
  EXPECT_TRUE(calibration.frames_left_out.empty());
  EXPECT_NEAR(calibration.models.back().rms_px, 0.2 * std::sqrt(2.0), 0.01);
}

TEST(CalibrationFaultsTest, FocusThatChangedBetweenImagesIsNamed) {
  GeneratedBoards made = generate_boards(enough());
  const Eigen::Vector2d center = made.truth.lenses[0].parameters.segment<2>(2);
  for (std::size_t i = 1; i < made.input.views.size(); i += 2)
    for (Eigen::Vector2d& pixel : made.input.views[i].pixels) pixel = center + 1.01 * (pixel - center);
  EXPECT_THAT(told(judged(made.input)), HasSubstr("two halves of the images differ"));
}

TEST(CalibrationFaultsTest, CornersOfAWideLensThatFewBoardsSawDoNotMakeHalvesDiffer) {
  // The difference lies in one direction of the lens, at 2.6 times its standard deviation.
  const CalibrationTrust trust =
      judged(generate_boards({.model = LensModel::equidistant, .seed = 101, .frames = 40}).input);
  EXPECT_GT(trust.halves.difference_px, 2.0 * trust.halves.expected_px);
  EXPECT_TRUE(trust.halves.agree);
}

TEST(CalibrationFaultsTest, BoardsInTheMiddleOnlyAreNamed) {
  GeneratedOptions options = enough();
  options.frames = 24;
  options.only_middle = true;
  const CalibrationTrust trust = judged(generate_boards(options).input);
  EXPECT_NE(trust.trust, Trust::good);
  EXPECT_GT(trust.uncertainty_largest_px, 1.0);
  EXPECT_THAT(trust.coverage.missing, Contains("everything but the center"));
  EXPECT_THAT(trust.coverage.missing, Contains("tilted boards"));
  EXPECT_THAT(trust.coverage.missing, Not(Contains("center")));
}

TEST(CalibrationFaultsTest, AWholeSideWithoutBoardsIsNamedOnce) {
  GeneratedBoards made = generate_boards(enough());
  std::erase_if(made.input.views, [](const BoardView& view) {
    return std::any_of(view.pixels.begin(), view.pixels.end(), [](const Eigen::Vector2d& p) { return p.x() < 215.0; });
  });
  BoardSolution solution{made.truth, {}, 0.0, 0, {}, true};
  solution.problem.views = made.input.views;
  const BoardCoverage coverage = board_coverage(solution, 0, 640, 480);
  EXPECT_THAT(coverage.missing, Contains("the whole left side"));
  EXPECT_THAT(coverage.missing, Not(Contains("left")));
  EXPECT_THAT(coverage.missing, Not(Contains("upper left")));
}

TEST(CalibrationFaultsTest, WrongSquareSizeShowsAgainstAKnownBaselineAlone) {
  GeneratedOptions options = enough();
  options.stereo = true;
  GeneratedBoards made = generate_boards(options);
  const CameraCalibration right_size = calibrate_camera(made.input);
  CalibrationTrust trust = judge_calibration(right_size, 1, 640, 480);
  const double baseline = made.truth.right_from_left.inverse().translation().norm();
  judge_baseline(right_size, baseline, trust);
  EXPECT_THAT(trust.doubts, IsEmpty());
  const SE3 off = right_size.solution.problem.right_from_left * made.truth.right_from_left.inverse();
  const int at = right_size.solution.parameters.right_from_left;
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(std::abs(off.rotation().log()[i]), 4.0 * std::sqrt(right_size.covariance(at + i, at + i)));
    EXPECT_LT(std::abs(right_size.solution.problem.right_from_left.translation()[i] -
                       made.truth.right_from_left.translation()[i]),
              4.0 * std::sqrt(right_size.covariance(at + 3 + i, at + 3 + i)));
  }
  for (Eigen::Vector2d& point : made.input.board) point *= 1.03;
  const CameraCalibration wrong_size =
      calibrate_camera(made.input, {.model = LensModel::pinhole_4, .compare_models = false});
  EXPECT_NEAR(wrong_size.solution.rms_px(), right_size.solution.rms_px(), 1e-3);  // No image tells it.
  CalibrationTrust wrong;
  judge_baseline(wrong_size, baseline, wrong);
  EXPECT_THAT(told(wrong), HasSubstr("wrong square size"));
}

TEST(CalibrationFaultsTest, TooLittleIsAnErrorOfOneLine) {
  GeneratedBoards made = generate_boards({.frames = 2});
  EXPECT_THROW(calibrate_camera(made.input), Error);
  made.input.width = 0;
  EXPECT_THROW(calibrate_camera(made.input), Error);
}

}  // namespace
}  // namespace rastro
