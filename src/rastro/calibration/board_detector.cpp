// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/board_detector.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "rastro/calibration/board_image.h"

namespace rastro {
namespace {

constexpr int search_size = 640;

bool search_corners(const cv::Mat& image, const cv::Size& size, std::vector<cv::Point2f>& corners) {
  const auto whole = [&] { return corners.size() == static_cast<std::size_t>(size.area()); };
  if (!cv::checkChessboard(image, size)) return false;
  if (cv::findChessboardCorners(image, size, corners, cv::CALIB_CB_ADAPTIVE_THRESH) && whole()) return true;
  // Slower, and finds most of the boards that are tilted by 45 degrees and more (Duda and Frese 2018).
  return cv::findChessboardCornersSB(image, size, corners) && whole();
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

void refine_corners(const cv::Mat& image, const Board& board, std::vector<cv::Point2f>& corners) {
  const int half = std::clamp(static_cast<int>(smallest_step(corners, board) / 3.0), 2, 11);
  const cv::TermCriteria stop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 40, 1e-3);
  cv::cornerSubPix(image, corners, {half, half}, {-1, -1}, stop);
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
