// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

#include "rastro/base/random.h"
#include "rastro/calibration/board.h"
#include "rastro/calibration/calibrate.h"

namespace rastro {

/// Views of a board whose every number is known.
struct GeneratedBoards {
  BoardProblem truth;
  CalibrationInput input;  ///< The same corners with noise, as a detector would give them.
};

struct GeneratedOptions {
  LensModel model = LensModel::pinhole_4;
  std::uint64_t seed = 1;
  int frames = 24;
  double noise_px = 0.2;
  BoardShape shape = {};
  bool stereo = false;
  bool only_middle = false;  ///< Every board small, upright and in the middle of the image.
  bool upright = false;
  Board board = {9, 6, 0.025};
};

inline Lens generated_lens(LensModel model) {
  Lens lens = undistorted_lens(model, 500.0, {322.0, 236.0});
  Eigen::VectorXd& p = lens.parameters;
  p[1] = 503.0;
  if (model == LensModel::equidistant) {
    p.segment<4>(4) << 0.02, -0.01, 0.004, -0.001;
    p.head<2>() *= 0.6;
  } else {
    p.segment<4>(4) << -0.28, 0.09, 0.0004, -0.0003;
    if (model == LensModel::pinhole_5) p[8] = -0.02;
    if (model == LensModel::pinhole_8) {
      // Wide, or numerator and denominator could not be told apart.
      p.segment<8>(4) << 0.5, -0.3, 0.0004, -0.0003, 0.3, 0.6, 0.1, 0.3;
      p.head<2>() << 220.0, 223.0;
    }
  }
  return lens;
}

/// A board pose with the board's center seen near a random place of the image.
inline SE3 generated_pose(const BoardProblem& problem, const GeneratedOptions& options, Random& random) {
  const auto angle = [&](double degrees) { return random.uniform(-degrees, degrees) * std::numbers::pi / 180.0; };
  const double reach = options.only_middle ? 0.03 : 1.0;
  const Eigen::Vector2d pixel(319.5 + reach * random.uniform(-230.0, 230.0),
                              239.5 + reach * random.uniform(-160.0, 160.0));
  const double distance = options.only_middle ? random.uniform(0.75, 0.85) : random.uniform(0.3, 0.6);
  const double tilt = options.only_middle ? 3.0 : 40.0;
  const SO3 rotation =
      SO3::exp({angle(tilt), angle(tilt), 0.0}) * SO3::exp({0.0, 0.0, options.upright ? angle(4.0) : angle(90.0)});
  const Eigen::Vector3d ray = problem.lenses.front().unproject(pixel).value_or(Eigen::Vector3d::UnitZ());
  const Eigen::Vector2d middle = 0.5 * problem.board.back();
  return {rotation, ray * distance - rotation * Eigen::Vector3d(middle.x(), middle.y(), 0.0)};
}

/// Whether every corner is in the image, or with `in_part` twelve of them; then `view` has them with noise.
inline bool generate_view(const BoardProblem& problem, const SE3& camera_from_board, double noise_px, bool in_part,
                          Random& random, BoardView& view) {
  for (int i = 0; i < static_cast<int>(problem.board.size()); ++i) {
    const auto seen =
        problem.lenses[static_cast<std::size_t>(view.camera)].project(camera_from_board * board_point(problem, i));
    if (!seen || seen->pixel.minCoeff() < 3.0 || seen->pixel.x() > 636.0 || seen->pixel.y() > 476.0) {
      if (!in_part) return false;
      continue;
    }
    view.corners.push_back(i);
    view.pixels.push_back(seen->pixel + noise_px * Eigen::Vector2d(random.normal(), random.normal()));
  }
  return view.corners.size() >= 12;
}

inline GeneratedBoards generate_boards(const GeneratedOptions& options) {
  GeneratedBoards made;
  Random random(options.seed);
  BoardProblem& truth = made.truth;
  truth.board = options.board.points();
  truth.lenses = {generated_lens(options.model)};
  if (options.stereo) {
    truth.lenses.push_back(truth.lenses.front());
    truth.lenses.back().parameters.head<4>() += Eigen::Vector4d(2.0, 1.0, -3.0, 4.0);
    truth.right_from_left = {SO3::exp({0.004, -0.01, 0.003}), {-0.06, 0.001, 0.0005}};
  }
  truth.shape = options.shape;
  const bool in_part = options.board.kind != BoardKind::chessboard;
  for (int frame = 0; frame < options.frames;) {
    const SE3 pose = generated_pose(truth, options, random);
    BoardView left{frame, 0, {}, {}}, right{frame, 1, {}, {}};
    if (!generate_view(truth, pose, options.noise_px, in_part, random, left)) continue;
    if (options.stereo && !generate_view(truth, truth.right_from_left * pose, options.noise_px, in_part, random, right))
      continue;
    truth.left_from_board.push_back(pose);
    made.input.views.push_back(left);
    if (options.stereo) made.input.views.push_back(right);
    made.input.frames.push_back("frame " + std::to_string(frame++));
  }
  made.input.board = truth.board;
  made.input.width = 640;
  made.input.height = 480;
  made.input.stereo = options.stereo;
  return made;
}

}  // namespace rastro
