// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <opencv2/imgproc.hpp>

#include "rastro/calibration/board_dictionary.h"
#include "rastro/calibration/board_rendering_testing.h"
#include "rastro/calibration/boards_testing.h"

namespace rastro {

/// What a detector must find. Rendered with blur of 0.8 px (standard deviation) and noise of 4 gray levels.
struct GoodView {
  static constexpr double margin_share = 0.03;   ///< Every corner is so far inside the image, of its width.
  static constexpr double most_tilt_deg = 60.0;  ///< Between the line of sight and the normal, at the board's middle.
  static constexpr double least_step_px = 8.0;   ///< Between neighboring corners of a chessboard, in 640x480.
  static constexpr double least_cell_px = 2.0;   ///< Of every tag, its shortest side over its cells.

  GrayImage image;
  std::vector<Eigen::Vector2d> corners;  ///< True positions.
};

/// Good views of a board, at 640x480 times `scale`, cut to 16:9 (at 6: 3840x2160).
class GoodViews {
 public:
  GoodViews(const Board& board, std::uint64_t seed, int scale = 1)
      : board_(board),
        options_{.board = board},
        random_(seed),
        scale_(scale),
        cut_(scale > 1 ? 60 * scale : 0),
        lens_(scaled_lens()),
        renderer_(board, lens_, width(), height()) {
    flat_.board = board.points();
    flat_.lenses = {generated_lens(options_.model)};
  }

  int width() const { return 640 * scale_; }
  int height() const { return 480 * scale_ - 2 * cut_; }

  GoodView next() {
    for (;;) {
      const SE3 pose = generated_pose(flat_, options_, random_);
      std::vector<Eigen::Vector2d> corners = project(pose);
      if (corners.empty() || tilt_deg(pose) > GoodView::most_tilt_deg || !large_enough(corners)) continue;
      GoodView view{renderer_.render(pose, 4.0, random_), std::move(corners)};
      cv::Mat image(height(), width(), CV_8UC1, view.image.row(0), static_cast<std::size_t>(view.image.view().stride));
      cv::GaussianBlur(image, image, {}, 0.8);
      return view;
    }
  }

 private:
  Lens scaled_lens() const {
    Lens lens = generated_lens(options_.model);
    Eigen::VectorXd& p = lens.parameters;
    p.head<2>() *= scale_;
    p[2] = (p[2] + 0.5) * scale_ - 0.5;
    p[3] = (p[3] + 0.5) * scale_ - 0.5 - cut_;
    return lens;
  }

  /// Empty where one is not in the image.
  std::vector<Eigen::Vector2d> project(const SE3& pose) const {
    std::vector<Eigen::Vector2d> corners;
    const double margin = GoodView::margin_share * width();
    for (int k = 0; k < static_cast<int>(flat_.board.size()); ++k) {
      const auto seen = lens_.project(pose * board_point(flat_, k));
      if (!seen || seen->pixel.minCoeff() < margin || seen->pixel.x() > width() - margin ||
          seen->pixel.y() > height() - margin)
        return {};
      corners.push_back(seen->pixel);
    }
    return corners;
  }

  double tilt_deg(const SE3& pose) const {
    const Eigen::Vector2d middle = 0.5 * flat_.board.back();
    const Eigen::Vector3d sight = (pose * Eigen::Vector3d(middle.x(), middle.y(), 0.0)).normalized();
    return std::acos(std::abs(sight.dot(pose.rotation() * Eigen::Vector3d::UnitZ()))) * 180.0 / std::numbers::pi;
  }

  bool large_enough(const std::vector<Eigen::Vector2d>& corners) const {
    double shortest = std::numeric_limits<double>::max();
    if (board_.kind == BoardKind::apriltag) {
      for (std::size_t i = 0; i < corners.size(); ++i)
        shortest = std::min(shortest, (corners[i] - corners[i / 4 * 4 + (i + 1) % 4]).norm());
    } else {
      for (std::size_t i = 1; i < corners.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) shortest = std::min(shortest, (corners[i] - corners[j]).norm());
    }
    if (board_.kind == BoardKind::chessboard) return shortest >= GoodView::least_step_px;
    const double tag = board_.kind == BoardKind::charuco ? shortest * board_.tag_m / board_.square_m : shortest;
    return tag >= GoodView::least_cell_px * static_cast<double>(tag_cells(board_.tags, 0).size());
  }

  Board board_;
  GeneratedOptions options_;
  Random random_;
  int scale_, cut_;
  Lens lens_;
  BoardProblem flat_;
  BoardRenderer renderer_;
};

}  // namespace rastro
