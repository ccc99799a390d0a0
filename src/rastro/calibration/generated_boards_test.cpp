// SPDX-License-Identifier: Apache-2.0
// Calibrations of generated boards: is each error as large as its claimed standard deviation says?
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "rastro/calibration/boards_testing.h"
#include "rastro/calibration/projection_uncertainty.h"

namespace rastro {
namespace {

/// Where the calibrated lens sees a point that the true one sees at the same place of every board: as
/// projection_covariance() has it, with the errors in place of the covariance.
Eigen::Vector2d projection_error(const BoardProblem& truth, const BoardSolution& solution, const Eigen::Vector2d& pixel,
                                 double distance) {
  const BoardProblem& found = solution.problem;
  const Eigen::Vector3d point = truth.lenses[0].unproject(pixel).value() * distance;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  int frames = 0;
  for (std::size_t i = 0; i < truth.left_from_board.size(); ++i) {
    if (solution.parameters.poses[i] < 0) continue;
    mean += found.left_from_board[i] * (truth.left_from_board[i].inverse() * point);
    ++frames;
  }
  return found.lenses[0].project(mean / frames).value().pixel - pixel;
}

struct GeneratedCase {
  const char* name;
  LensModel model;
  const char* board;
};

class GeneratedBoardsTest : public testing::TestWithParam<GeneratedCase> {};

TEST_P(GeneratedBoardsTest, ErrorsAreAsLargeAsClaimed) {
  constexpr int seeds = 3;
  Eigen::VectorXd chi_square;
  double all_chi_square = 0.0;
  int inside = 0, points = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const GeneratedBoards made = generate_boards(
        {.model = GetParam().model, .seed = static_cast<std::uint64_t>(seed), .board = parse_board(GetParam().board)});
    CalibrationOptions options{.model = GetParam().model, .compare_models = false};
    const CameraCalibration calibration = calibrate_camera(made.input, options);
    const BoardSolution& solution = calibration.solution;
    EXPECT_TRUE(calibration.frames_left_out.empty());
    EXPECT_FALSE(calibration.shape.bowed || calibration.shape.stretched);
    EXPECT_NEAR(solution.noise_px(), 0.2, 0.01);
    const Eigen::VectorXd error = solution.problem.lenses[0].parameters - made.truth.lenses[0].parameters;
    const Eigen::VectorXd square = error.cwiseQuotient(calibration.lens_sigmas(0)).cwiseAbs2();
    chi_square = seed == 1 ? square : Eigen::VectorXd(chi_square + square);
    const Eigen::MatrixXd block = calibration.covariance.topLeftCorner(error.size(), error.size());
    const Eigen::VectorXd scale = block.diagonal().cwiseSqrt().cwiseInverse();
    all_chi_square += error.cwiseProduct(scale).dot((scale.asDiagonal() * block * scale.asDiagonal()).inverse() *
                                                    error.cwiseProduct(scale));
    for (int x = 20; x < 640; x += 60)
      for (int y = 20; y < 480; y += 55) {
        const Eigen::Vector2d pixel(x, y);
        const auto claimed = projection_covariance(solution, calibration.covariance, 0, pixel, 0.5);
        if (!claimed || !made.truth.lenses[0].unproject(pixel)) continue;
        const Eigen::Vector2d off = projection_error(made.truth, solution, pixel, 0.5);
        inside += off.dot(claimed->inverse() * off) < 5.991 ? 1 : 0;  // 95 % of two dimensions.
        ++points;
      }
  }
  // Chi-square of 3 degrees of freedom: 0.01 % below 0.005 or above 21.1.
  for (const double sum : chi_square) {
    EXPECT_GT(sum, 0.005);
    EXPECT_LT(sum, 21.1);
  }
  const double n = seeds * static_cast<double>(chi_square.size()), spread = 4.0 * std::sqrt(2.0 * n);
  EXPECT_NEAR(all_chi_square, n, spread);
  const double share = static_cast<double>(inside) / points;
  RecordProperty("inside", std::to_string(share));
  RecordProperty("chi_square", std::to_string(all_chi_square / n));
  EXPECT_GT(share, 0.85);
}

constexpr const char* chessboard = "chessboard:9x6:0.025";
constexpr GeneratedCase generated_cases[] = {
    {"pinhole4", LensModel::pinhole_4, chessboard},
    {"pinhole5", LensModel::pinhole_5, chessboard},
    {"equidistant", LensModel::equidistant, chessboard},
    {"pinhole8", LensModel::pinhole_8, chessboard},
    {"pinhole4_charuco_in_part", LensModel::pinhole_4, "charuco:10x7:0.04:0.03"},
    {"pinhole4_apriltags_in_part", LensModel::pinhole_4, "apriltag:5x4:0.06:0.018"},
};

INSTANTIATE_TEST_SUITE_P(Models, GeneratedBoardsTest, testing::ValuesIn(generated_cases),
                         [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace rastro
