// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "rastro/math/se3.h"
#include "rastro/optimize/lens.h"

namespace rastro {

/// Corners of a board in one image of one camera.
struct BoardView {
  int frame = 0;                        ///< Which board pose; the same for both images of a pair.
  int camera = 0;                       ///< 0, or 1 for the right camera.
  std::vector<int> corners;             ///< Which point of the board.
  std::vector<Eigen::Vector2d> pixels;  ///< Where it was seen; as many.
};

/// How a board differs from its drawing.
struct BoardShape {
  double bow_x_m = 0.0;  ///< Height of the middle over the edges along x: z = bow_x (1 - u^2), u from -1 to 1.
  double bow_y_m = 0.0;
  double stretch_y = 0.0;  ///< Share by which squares are higher than wide, beyond the drawing.
};

/// Bundle adjustment of cameras that see a board of known shape (Zhang 2000, "A flexible new technique for camera
/// calibration", with the pose of every board view free).
struct BoardProblem {
  std::vector<Eigen::Vector2d> board;  ///< Points in the plane of the board, meters.
  std::vector<Lens> lenses;            ///< One, or two of a pair.
  SE3 right_from_left;                 ///< Of a pair.
  std::vector<SE3> left_from_board;    ///< Per frame, also where only the right camera sees it.
  BoardShape shape;
  std::vector<BoardView> views;
};

struct BoardAdjustmentOptions {
  int iterations = 100;
  double huber_px = 0.0;  ///< Width of Huber's kernel; 0: least squares.
  bool free_lenses = true;
  bool free_bow = false;
  bool free_stretch = false;
};

/// Where the parameters of a problem stand in its covariance.
struct BoardParameters {
  std::vector<int> lenses;   ///< First index of each lens; -1 if not free.
  int right_from_left = -1;  ///< Rotation (exp from the left), translation; -1 if not free.
  int bow = -1, stretch = -1;
  std::vector<int> poses;  ///< Of left_from_board; -1 for frames without a view.
  int count = 0;
};

struct BoardSolution {
  BoardProblem problem;                                 ///< With the estimates in place of the start.
  std::vector<std::vector<Eigen::Vector2d>> residuals;  ///< Observed minus projected, per view and corner, pixels.
  double squared_error = 0.0;                           ///< Sum of their squares, without the kernel.
  int measurements = 0;                                 ///< Two per corner.
  BoardParameters parameters;
  bool converged = false;

  int degrees_of_freedom() const { return measurements - parameters.count; }
  /// Standard deviation of a corner's coordinate, from the residuals; pixels.
  double noise_px() const;
  /// Root mean square of the distance between corner and projection, as OpenCV counts it; pixels.
  double rms_px() const;
};

/// The denominator of the rational model has a weak prior (0.01 px a unit), which residuals and measurements leave out.
/// Always the same bytes for the same problem. A view must have as many pixels as corners, and at least four.
BoardSolution adjust_boards(const BoardProblem& problem, const BoardAdjustmentOptions& options);

/// Covariance of all parameters for a noise of one pixel: the inverse of the normal equations, the poses as small
/// rotations from the left and translations. nullopt where the views do not determine all parameters.
std::optional<Eigen::MatrixXd> board_covariance(const BoardSolution& solution);

/// Point of the board in its own frame.
Eigen::Vector3d board_point(const BoardProblem& problem, int corner);

}  // namespace rastro
