// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/board_detector.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "rastro/calibration/board_image.h"
#include "rastro/calibration/contrast_area.h"

namespace rastro {
namespace {

constexpr int search_size = 640;

/// Where squares of a tilted board are thin, thresholds that part them by darkness find it (the adaptive ones of OpenCV
/// join them, and cost 100 ms where no board is).
constexpr double parting_levels[] = {0.3, 0.2};
constexpr float largest_scale = 3.0F;
constexpr int largest_side = 1000;

bool find_chessboard(const cv::Mat& image, const cv::Size& size, std::vector<cv::Point2f>& corners) {
  return cv::findChessboardCorners(image, size, corners, 0) && corners.size() == static_cast<std::size_t>(size.area());
}

bool search_corners(const cv::Mat& image, const cv::Size& size, std::vector<cv::Point2f>& corners) {
  if (!cv::checkChessboard(image, size)) return false;
  if (find_chessboard(image, size, corners)) return true;
  const auto area = contrast_area(image, largest_scale, largest_side);
  if (!area) return false;
  for (const double level : parting_levels) {
    const cv::Mat bright = ~area->dark(level);
    if (!find_chessboard(bright, size, corners)) continue;
    for (cv::Point2f& corner : corners) corner = area->in_image(corner);
    return true;
  }
  return false;
}

/// Smallest distance between neighbors of the grid, pixels.
double smallest_step(const std::vector<cv::Point2f>& corners, const Board& board) {
  double smallest = 1e9;
  for (int y = 0; y < board.rows; ++y)
    for (int x = 0; x < board.columns; ++x) {
      const cv::Point2f& here = corners[static_cast<std::size_t>(y * board.columns + x)];
      if (x > 0)
        smallest = std::min(smallest, cv::norm(here - corners[static_cast<std::size_t>(y * board.columns + x - 1)]));
      if (y > 0)
        smallest = std::min(smallest, cv::norm(here - corners[static_cast<std::size_t>((y - 1) * board.columns + x)]));
    }
  return smallest;
}

/// Where the three corners beside one on its row or column say that it is, in each direction that has three.
std::vector<cv::Point2f> said_by_neighbors(const std::vector<cv::Point2f>& corners, const Board& board, int x, int y) {
  constexpr int directions[][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  std::vector<cv::Point2f> said;
  for (const auto& [dx, dy] : directions) {
    const int far_x = x + 3 * dx, far_y = y + 3 * dy;
    if (far_x < 0 || far_y < 0 || far_x >= board.columns || far_y >= board.rows) continue;
    const auto at = [&, dx = dx, dy = dy](int steps) {
      return corners[static_cast<std::size_t>((y + steps * dy) * board.columns + x + steps * dx)];
    };
    said.push_back(3.0F * (at(1) - at(2)) + at(3));
  }
  return said;
}

/// Puts corners back where their rows and columns have them: where the end of a board is steep or cut, the search may
/// put one on another edge. One that is wrong spoils what it says of others, but no corner in all directions.
std::vector<std::size_t> put_back(std::vector<cv::Point2f>& corners, const Board& board, double most_off) {
  const std::vector<cv::Point2f> before = corners;
  std::vector<std::size_t> moved;
  for (int y = 0; y < board.rows; ++y)
    for (int x = 0; x < board.columns; ++x) {
      const auto said = said_by_neighbors(before, board, x, y);
      const auto index = static_cast<std::size_t>(y * board.columns + x);
      const auto off = [&](const cv::Point2f& p) { return cv::norm(p - before[index]); };
      if (said.empty() || std::any_of(said.begin(), said.end(), [&](const auto& p) { return off(p) <= most_off; }))
        continue;
      corners[index] =
          *std::min_element(said.begin(), said.end(), [&](const auto& a, const auto& b) { return off(a) < off(b); });
      moved.push_back(index);
    }
  return moved;
}

void refine_corners(const cv::Mat& image, const Board& board, std::vector<cv::Point2f>& corners) {
  const double step = smallest_step(corners, board);
  const int half = std::clamp(static_cast<int>(step / 3.0), 2, 11);
  const cv::TermCriteria stop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 40, 1e-3);
  cv::cornerSubPix(image, corners, {half, half}, {-1, -1}, stop);
  for (const std::size_t index : put_back(corners, board, 0.15 * step)) {
    std::vector<cv::Point2f> one = {corners[index]};
    cv::cornerSubPix(image, one, {2, 2}, {-1, -1}, stop);
    corners[index] = one.front();
  }
}

std::optional<DetectedBoard> detect_chessboard(const cv::Mat& full, const Board& board) {
  const int largest = std::max(full.cols, full.rows);
  std::vector<cv::Point2f> corners;
  for (int factor = std::max(1, (largest + search_size / 2) / search_size);; factor = (factor + 1) / 2) {
    const cv::Mat small = reduced_image(full, factor);
    if (search_corners(small, {board.columns, board.rows}, corners)) {
      if (factor > 1)
        for (cv::Point2f& corner : corners) corner = in_full_image(corner, factor);
      break;
    }
    // A board far away may be too small in the reduced image; in images up to twice the size it is searched once more.
    if (factor == 1 || factor > 2) return std::nullopt;
  }
  refine_corners(full, board, corners);
  // Both searches begin where they like; alike images of a pair should begin at the same end.
  const cv::Point2f way = corners.back() - corners.front();
  if (way.x + 2.0F * way.y < 0.0F) std::reverse(corners.begin(), corners.end());
  DetectedBoard found;
  for (const cv::Point2f& corner : corners) {
    if (!(corner.x >= 0.0F && corner.y >= 0.0F && corner.x < static_cast<float>(full.cols) &&
          corner.y < static_cast<float>(full.rows)))
      return std::nullopt;
    found.corners.push_back(static_cast<int>(found.corners.size()));
    found.pixels.emplace_back(corner.x, corner.y);
  }
  return found;
}

}  // namespace

cv::Mat reduced_image(const cv::Mat& image, int factor) {
  if (factor == 1) return image;
  cv::Mat small;
  const cv::Rect whole(0, 0, image.cols / factor * factor, image.rows / factor * factor);
  cv::resize(image(whole), small, {image.cols / factor, image.rows / factor}, 0.0, 0.0, cv::INTER_AREA);
  return small;
}

std::optional<DetectedBoard> detect_board(GrayView image, const Board& board) {
  if (image.width < 32 || image.height < 32) return std::nullopt;
  const cv::Mat full(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.data),
                     static_cast<std::size_t>(image.stride));
  return board.kind == BoardKind::chessboard ? detect_chessboard(full, board) : detect_tags(full, board);
}

}  // namespace rastro
