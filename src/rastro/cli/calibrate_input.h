// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/calibration/board.h"
#include "rastro/calibration/calibrate.h"
#include "rastro/cli/common_flags.h"
#include "rastro/cli/progress_bar.h"
#include "rastro/image/image.h"

namespace rastro::cli {

struct BoardImages {
  CalibrationInput input;
  int images = 0;                  ///< Searched.
  int near_another = 0;            ///< Not used: the board was where it was in another image.
  std::vector<DepthImage> depths;  ///< Per frame of the input; empty where there is none.
  double depth_factor = 0.0;       ///< Raw units per meter, where there is depth.
};

struct BoardSearchOptions {
  std::string right;  ///< The images of the right camera, one for each of the left; empty for one camera.
  std::size_t most_views = 100;
  bool want_depth = false;
};

/// Searches the board in every image. Error for images of different sizes and where nothing can be read.
BoardImages find_boards(const DataFlags& flags, const Board& board, const BoardSearchOptions& search_for,
                        ProgressBar& bar);

/// From a live source: takes a view whenever the board is held still and shows something new, says what is missing, and
/// ends when nothing is, at the end of the source or with Ctrl-C.
BoardImages find_boards_live(const DataFlags& flags, const Board& board, std::size_t most_views);

}  // namespace rastro::cli
