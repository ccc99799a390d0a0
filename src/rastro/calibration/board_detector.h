// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "rastro/calibration/board.h"
#include "rastro/image/image.h"

namespace rastro {

/// Corners of the chessboard in an image, in the order of Board::points(), to a fraction of a pixel; nullopt where not
/// all of them are seen. The board is searched in an image of at most about 640 pixels a side, and its corners are
/// refined in the full one (Foerstner's operator: cv::cornerSubPix), with a window of at most a third of the distance
/// between corners. Which of the board's two ends is first cannot be told from one image.
std::optional<std::vector<Eigen::Vector2d>> detect_board(GrayView image, const Board& board);

}  // namespace rastro
