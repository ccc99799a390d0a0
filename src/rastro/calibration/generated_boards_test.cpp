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
  int seeds;
};

/// Errors over what is claimed for them, summed over calibrations.
struct Errors {
  Eigen::VectorXd chi_square;     ///< Of each parameter of the lens, one degree of freedom a calibration.
  double joint_chi_square = 0.0;  ///< Of all of them with their covariance.
  int inside = 0, places = 0;     ///< Projections within the claimed 95 %, of places over the image.

  void add(const GeneratedBoards& made, const CameraCalibration& calibration);
  void add_projections(const BoardProblem& truth, const CameraCalibration& calibration);
};

void Errors::add(const GeneratedBoards& made, const CameraCalibration& calibration) {
  const Eigen::VectorXd error = calibration.solution.problem.lenses[0].parameters - made.truth.lenses[0].parameters;
  const Eigen::MatrixXd block = calibration.covariance.topLeftCorner(error.size(), error.size());
  const Eigen::VectorXd scaled = error.cwiseQuotient(calibration.lens_sigmas(0));
  const Eigen::VectorXd scale = block.diagonal().cwiseSqrt().cwiseInverse();
  if (chi_square.size() == 0) chi_square.setZero(error.size());
  chi_square += scaled.cwiseAbs2();
  joint_chi_square += scaled.dot((scale.asDiagonal() * block * scale.asDiagonal()).inverse() * scaled);
  add_projections(made.truth, calibration);
}

void Errors::add_projections(const BoardProblem& truth, const CameraCalibration& calibration) {
  constexpr double chi_square_95 = 5.991;  // Of two dimensions.
  for (int x = 20; x < 640; x += 60)
    for (int y = 20; y < 480; y += 55) {
      const Eigen::Vector2d pixel(x, y);
      const auto claimed = projection_covariance(calibration.solution, calibration.covariance, 0, pixel, 0.5);
      if (!claimed || !truth.lenses[0].unproject(pixel)) continue;
      const Eigen::Vector2d off = projection_error(truth, calibration.solution, pixel, 0.5);
      inside += off.dot(claimed->inverse() * off) < chi_square_95 ? 1 : 0;
      ++places;
    }
}

class GeneratedBoardsTest : public testing::TestWithParam<GeneratedCase> {};

TEST_P(GeneratedBoardsTest, ErrorsAreAsLargeAsClaimed) {
  const int seeds = GetParam().seeds;
  Errors errors;
  for (int seed = 1; seed <= seeds; ++seed) {
    const GeneratedBoards made = generate_boards(
        {.model = GetParam().model, .seed = static_cast<std::uint64_t>(seed), .board = parse_board(GetParam().board)});
    const CameraCalibration calibration =
        calibrate_camera(made.input, {.model = GetParam().model, .compare_models = false});
    EXPECT_TRUE(calibration.frames_left_out.empty());
    EXPECT_FALSE(calibration.shape.bowed || calibration.shape.stretched);
    EXPECT_NEAR(calibration.solution.noise_px(), 0.2, 0.01);
    errors.add(made, calibration);
  }
  // Four standard deviations, by the cube root that is nearly normal (Wilson and Hilferty 1931): 1 in 16,000 is
  // outside.
  const auto bounds = [](double freedom) {
    const double spread = std::sqrt(2.0 / (9.0 * freedom)), middle = 1.0 - 2.0 / (9.0 * freedom);
    return std::pair(freedom * std::pow(std::max(0.0, middle - 4.0 * spread), 3),
                     freedom * std::pow(middle + 4.0 * spread, 3));
  };
  const auto [low, high] = bounds(seeds);
  for (const double sum : errors.chi_square) {
    EXPECT_GT(sum, low);
    EXPECT_LT(sum, high);
  }
  const double freedom = seeds * static_cast<double>(errors.chi_square.size());
  const auto [joint_low, joint_high] = bounds(freedom);
  EXPECT_GT(errors.joint_chi_square, joint_low);
  EXPECT_LT(errors.joint_chi_square, joint_high);
  const double share = static_cast<double>(errors.inside) / errors.places;
  std::printf("%s: %.3f of the places within the claimed 95 %%, chi-square %.3f per parameter\n", GetParam().name,
              share, errors.joint_chi_square / freedom);
  EXPECT_GT(share, 0.90);
  EXPECT_LT(share, 0.98);
}

constexpr const char* chessboard = "chessboard:9x6:0.025";
// Shares of one calibration are all high or all low, so that boards seen in part, which differ more, need more of them.
constexpr GeneratedCase generated_cases[] = {
    {"pinhole4", LensModel::pinhole_4, chessboard, 20},
    {"pinhole5", LensModel::pinhole_5, chessboard, 20},
    {"equidistant", LensModel::equidistant, chessboard, 20},
    {"pinhole8", LensModel::pinhole_8, chessboard, 20},
    {"pinhole4_charuco_in_part", LensModel::pinhole_4, "charuco:10x7:0.04:0.03", 40},
    {"pinhole4_apriltags_in_part", LensModel::pinhole_4, "apriltag:5x4:0.06:0.018", 40},
};

INSTANTIATE_TEST_SUITE_P(Models, GeneratedBoardsTest, testing::ValuesIn(generated_cases),
                         [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace rastro
