// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/calibration/board.h"
#include "rastro/calibration/calibrate.h"
#include "rastro/calibration/depth_calibration.h"
#include "rastro/cli/common_flags.h"
#include "rastro/cli/progress_bar.h"
#include "rastro/image/image.h"
#include "rastro/sensor/source.h"

namespace rastro::cli {

class LiveBoards;

struct BoardImages {
  CalibrationInput input;
  int images = 0;                  ///< Searched.
  int found = 0;                   ///< Of these, with the board.
  int near_another = 0;            ///< Not used: the board was where it was in another image.
  std::vector<DepthImage> depths;  ///< Per frame of the input; empty where there is none.
  DepthAsRead depth_as_read;
};

/// The depth of a source, as it was read.
DepthAsRead depth_as_read(const SourceInfo& info);

struct BoardSearchOptions {
  /// The images of the right camera, one for each of the left, or a live source beside the left one; empty for one
  /// camera, and where DATA has both images.
  std::string right;
  std::size_t most_views = 100;
  bool stereo = false;  ///< Both images of DATA.
  bool want_depth = false;
  bool raw_depth = false;  ///< As the depth camera sees it, not put into the color image.

  bool is_pair() const { return stereo || !right.empty(); }
};

/// Searches the board in every image. Of two sources the images of one number belong together, and where one of them
/// cannot be read the other is used alone. Error for images of different sizes and for two sources of different length.
BoardImages find_boards(const DataFlags& flags, const Board& board, const BoardSearchOptions& search_for,
                        ProgressBar& bar);

/// From a live source or two: takes a view whenever the board is held still and shows something new, says what is
/// missing, and ends when nothing is, at the end of the source or with Ctrl-C. Of a pair both images of a view are of
/// the same moment, or of two sources less than 0.1 s apart; with depth, views without depth are not taken. Error where
/// the source has not what is asked for.
/// `page`: shows it in a browser; may be null.
BoardImages find_boards_live(const DataFlags& flags, const Board& board, const BoardSearchOptions& search_for,
                             LiveBoards* page = nullptr);

/// What is asked for: error where a recording or live source has not both images, or no depth.
void require_images(const SourceInfo& info, const BoardSearchOptions& search_for);

}  // namespace rastro::cli
