// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "rastro/base/random.h"
#include "rastro/calibration/board.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"
#include "rastro/optimize/lens.h"

namespace rastro {

/// Images of a printed board as a lens sees it: 3x3 rays per pixel, and noise.
class BoardRenderer {
 public:
  BoardRenderer(const Board& board, const Lens& lens, int width, int height)
      : rays_x_(width + 1, height + 1), rays_y_(width + 1, height + 1) {
    draw(board);
    const Camera camera = camera_of(lens, width, height);
    for (int y = 0; y <= height; ++y)
      for (int x = 0; x <= width; ++x) {
        const auto ray = camera.unproject({x - 0.5, y - 0.5});
        rays_x_.at(x, y) = ray ? static_cast<float>(ray->x()) : std::nanf("");
        rays_y_.at(x, y) = ray ? static_cast<float>(ray->y()) : std::nanf("");
      }
  }

  GrayImage render(const SE3& camera_from_board, double noise, Random& random) const {
    GrayImage image(rays_x_.width() - 1, rays_x_.height() - 1);
    const SE3 board_from_camera = camera_from_board.inverse();
    const Eigen::Matrix3d rotation = board_from_camera.rotation().matrix();
    const Eigen::Vector3d origin = board_from_camera.translation();
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x) {
        int dark = 0;
        for (int k = 0; k < 9; ++k) {
          const double u = (k % 3 + 0.5) / 3.0, v = (k / 3 + 0.5) / 3.0;
          const Eigen::Vector3d ray =
              rotation * Eigen::Vector3d(between(rays_x_, x, y, u, v), between(rays_y_, x, y, u, v), 1.0);
          dark += darkness((origin - ray * (origin.z() / ray.z())).head<2>());
        }
        const double value = 200.0 - 160.0 * dark / 9.0 + (noise > 0.0 ? noise * random.normal() : 0.0);
        image.at(x, y) = static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
      }
    return image;
  }

 private:
  static double between(const Image<float>& rays, int x, int y, double u, double v) {
    return (1.0 - v) * ((1.0 - u) * static_cast<double>(rays.at(x, y)) + u * static_cast<double>(rays.at(x + 1, y))) +
           v * ((1.0 - u) * static_cast<double>(rays.at(x, y + 1)) + u * static_cast<double>(rays.at(x + 1, y + 1)));
  }

  int darkness(const Eigen::Vector2d& point) const {
    const Eigen::Vector2d cell = (point - low_) / pitch_;
    if (!(cell.x() >= 0.0 && cell.y() >= 0.0 && cell.x() < drawn_.width() && cell.y() < drawn_.height())) return 0;
    return drawn_.at(static_cast<int>(cell.x()), static_cast<int>(cell.y()));
  }

  void draw(const Board& board) {
    // Squares and tags begin at whole cells of the drawing for tags of 2/3 of a square or grids with gaps of 3/10.
    pitch_ = (board.kind == BoardKind::apriltag ? board.tag_m : board.square_m) / 240.0;
    const auto black = black_rectangles(board);
    Eigen::Vector2d high(-1e9, -1e9);
    low_ = Eigen::Vector2d(1e9, 1e9);
    for (const BoardRectangle& r : black) {
      low_ = low_.cwiseMin(Eigen::Vector2d(r.x, r.y));
      high = high.cwiseMax(Eigen::Vector2d(r.x + r.width, r.y + r.height));
    }
    const auto cell = [&](double meters) { return static_cast<int>(std::lround(meters / pitch_)); };
    drawn_ = GrayImage(cell(high.x() - low_.x()), cell(high.y() - low_.y()));
    for (const BoardRectangle& r : black)
      for (int y = cell(r.y - low_.y()); y < cell(r.y + r.height - low_.y()); ++y)
        std::fill(drawn_.row(y) + cell(r.x - low_.x()), drawn_.row(y) + cell(r.x + r.width - low_.x()),
                  std::uint8_t{1});
  }

  Image<float> rays_x_, rays_y_;
  GrayImage drawn_;
  Eigen::Vector2d low_;
  double pitch_ = 1.0;
};

}  // namespace rastro
