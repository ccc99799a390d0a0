// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "rastro/calibration/board.h"
#include "rastro/image/image.h"

namespace rastro {

/// Corners of a board in an image.
struct DetectedBoard {
  std::vector<int> corners;             ///< Which of Board::points(), in growing order.
  std::vector<Eigen::Vector2d> pixels;  ///< As many, to a fraction of a pixel.
};

/// The board in an image. A chessboard: all corners or nullopt, and which of its two ends is first cannot be told from
/// one image. Boards with tags (Garrido-Jurado et al. 2014; Olson 2011): those corners that are seen, nullopt for fewer
/// than six or where all lie on a line. The board is searched in an image of at most about 640 pixels a side (tags:
/// 1000), and its corners are refined in the full one (Foerstner's operator: cv::cornerSubPix), in a window that holds
/// no other edges.
std::optional<DetectedBoard> detect_board(GrayView image, const Board& board);

}  // namespace rastro
