// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/board_detector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rastro/calibration/boards_testing.h"

namespace rastro {
namespace {

/// Whether the point of the board is black: squares of a chessboard around and between its corners, white beyond.
double darkness(const Board& board, const Eigen::Vector2d& point) {
  const double x = point.x() / board.square_m + 1.0, y = point.y() / board.square_m + 1.0;
  if (x < 0.0 || y < 0.0 || x >= board.columns + 1 || y >= board.rows + 1) return 0.0;
  return (static_cast<int>(x) + static_cast<int>(y)) % 2 == 0 ? 1.0 : 0.0;
}

/// The board as the lens images it, by 3x3 rays per pixel, with blur of about a pixel and noise.
GrayImage render_board(const Board& board, const Lens& lens, const SE3& camera_from_board, int width, int height,
                       Random& random) {
  GrayImage image(width, height);
  const SE3 board_from_camera = camera_from_board.inverse();
  const Eigen::Matrix3d rotation = board_from_camera.rotation().matrix();
  const auto camera = camera_of(lens, width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double dark = 0.0;
      for (int k = 0; k < 9; ++k) {
        const auto plane = camera->unproject({x + (k % 3 - 1) / 3.0, y + (k / 3 - 1) / 3.0});
        if (!plane) continue;
        const Eigen::Vector3d ray = rotation * Eigen::Vector3d(plane->x(), plane->y(), 1.0);
        const Eigen::Vector3d origin = board_from_camera.translation();
        const Eigen::Vector3d hit = origin - ray * (origin.z() / ray.z());
        dark += darkness(board, hit.head<2>());
      }
      const double value = 200.0 - 160.0 * dark / 9.0 + 3.0 * random.normal();
      image.at(x, y) = static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
    }
  return image;
}

TEST(BoardDetectorTest, FindsTheCornersOfRenderedBoards) {
  const Board board{9, 6, 0.025};
  GeneratedOptions options{.seed = 7, .frames = 24};
  const GeneratedBoards made = generate_boards(options);
  Random random(1);
  int found = 0;
  double squared = 0.0;
  for (std::size_t i = 0; i < made.truth.left_from_board.size(); ++i) {
    const SE3& pose = made.truth.left_from_board[i];
    const GrayImage image = render_board(board, made.truth.lenses[0], pose, 640, 480, random);
    const auto corners = detect_board(image.view(), board);
    if (!corners) continue;
    ++found;
    const auto at = [&](int corner) {
      return made.truth.lenses[0].project(pose * board_point(made.truth, corner))->pixel;
    };
    const bool turned = (corners->front() - at(0)).norm() > (corners->back() - at(0)).norm();
    for (int k = 0; k < 54; ++k) {
      const Eigen::Vector2d off = (*corners)[static_cast<std::size_t>(turned ? 53 - k : k)] - at(k);
      EXPECT_LT(off.norm(), 0.5);
      squared += off.squaredNorm();
    }
  }
  EXPECT_GE(found, 23);
  EXPECT_LT(std::sqrt(squared / (54.0 * found)), 0.1);
}

TEST(BoardDetectorTest, NoBoardIsNotFound) {
  const Board board{9, 6, 0.025};
  Random random(2);
  GrayImage image(640, 480);
  EXPECT_FALSE(detect_board(image.view(), board));
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) image.at(x, y) = static_cast<std::uint8_t>(random.below(256));
  EXPECT_FALSE(detect_board(image.view(), board));
  EXPECT_FALSE(detect_board(GrayImage(3, 2).view(), board));
  EXPECT_FALSE(detect_board(GrayImage().view(), board));
}

}  // namespace
}  // namespace rastro
