// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/board_start.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

namespace rastro {
namespace {

constexpr double lost_view_px = 1e6;

struct StartView {
  std::optional<SE3> camera_from_board;
  double rms_px = lost_view_px;
};

SE3 transform_from(const cv::Mat& rotation, const cv::Mat& translation) {
  const auto vector = [](const cv::Mat& m) {
    return Eigen::Vector3d(m.at<double>(0), m.at<double>(1), m.at<double>(2));
  };
  return {SO3::exp(vector(rotation)), vector(translation)};
}

double rms_of(const SE3& camera_from_board, const std::vector<Eigen::Vector2d>& board, const BoardView& view,
              const Lens& lens) {
  double sum = 0.0;
  for (std::size_t i = 0; i < view.corners.size(); ++i) {
    const Eigen::Vector2d& flat = board[static_cast<std::size_t>(view.corners[i])];
    const auto seen = lens.project(camera_from_board * Eigen::Vector3d(flat.x(), flat.y(), 0.0));
    if (!seen) return lost_view_px;
    sum += (seen->pixel - view.pixels[i]).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(view.corners.size()));
}

StartView start_view(const std::vector<Eigen::Vector2d>& board, const BoardView& view, const Lens& lens) {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> rays;
  for (std::size_t i = 0; i < view.corners.size(); ++i) {
    const auto ray = lens.unproject(view.pixels[i]);
    if (!ray || ray->z() < 0.02) continue;
    const Eigen::Vector2d& flat = board[static_cast<std::size_t>(view.corners[i])];
    points.emplace_back(flat.x(), flat.y(), 0.0);
    rays.emplace_back(ray->x() / ray->z(), ray->y() / ray->z());
  }
  StartView result;
  if (points.size() < 4) return result;
  std::vector<cv::Mat> rotations, translations;
  try {
    cv::solvePnPGeneric(points, rays, cv::Matx33d::eye(), cv::noArray(), rotations, translations, false,
                        cv::SOLVEPNP_IPPE);
  } catch (const cv::Exception&) {
    return result;  // Corners that lie on a line.
  }
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const SE3 pose = transform_from(rotations[i], translations[i]);
    const double rms = rms_of(pose, board, view, lens);
    if (rms < result.rms_px) result = {pose, rms};
  }
  return result;
}

}  // namespace

std::optional<SE3> board_pose(const std::vector<Eigen::Vector2d>& board, const BoardView& view, const Lens& lens) {
  return start_view(board, view, lens).camera_from_board;
}

BoardStart start_boards(const std::vector<Eigen::Vector2d>& board, const std::vector<const BoardView*>& views,
                        LensModel model, int width, int height) {
  BoardStart best;
  best.median_rms_px = 2.0 * lost_view_px;
  const double size = std::max(width, height);
  for (double share = 0.25; share < 5.0; share *= 1.12) {
    BoardStart now{undistorted_lens(model, share * size, {0.5 * (width - 1), 0.5 * (height - 1)}), {}, 0.0};
    std::vector<double> errors;
    for (const BoardView* view : views) {
      const StartView start = start_view(board, *view, now.lens);
      now.camera_from_board.push_back(start.camera_from_board);
      errors.push_back(start.rms_px);
    }
    std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
    now.median_rms_px = errors[errors.size() / 2];
    if (now.median_rms_px < best.median_rms_px) best = std::move(now);
  }
  return best;
}

}  // namespace rastro
