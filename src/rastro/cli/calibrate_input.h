// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/calibration/board.h"
#include "rastro/calibration/calibrate.h"
#include "rastro/cli/common_flags.h"
#include "rastro/cli/progress_bar.h"

namespace rastro::cli {

struct BoardImages {
  CalibrationInput input;
  int images = 0;        ///< Searched.
  int near_another = 0;  ///< Not used: the board was where it was in another image.
};

/// Searches the board in every image. `right`: the images of the right camera, one for each of the left; empty for one
/// camera. Error for images of different sizes and where nothing can be read.
BoardImages find_boards(const DataFlags& flags, const std::string& right, const Board& board, std::size_t most_views,
                        ProgressBar& bar);

}  // namespace rastro::cli
