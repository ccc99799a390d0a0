// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rastro/calibration/board_detector.h"
#include "rastro/calibration/calibrate.h"

namespace rastro {

struct LiveAssistantOptions {
  int enough_views = 20;
  int most_views = 100;
  double still_share = 0.004;  ///< Of the image's width: a board that moved less since the last image is held still.
  double new_share = 0.06;     ///< A board whose corners are this far from those of every view taken is elsewhere.
};

/// Chooses views of a board from a live camera: sharp ones, since the board is held still, that show what is missing.
class LiveAssistant {
 public:
  enum class Answer {
    no_board,
    moving,       ///< Blurred, or soon to be.
    nothing_new,  ///< Such a view was taken.
    taken,
  };

  LiveAssistant(const Board& board, int width, int height, const LiveAssistantOptions& options = {});

  /// The next image: what was found in it, and its name.
  Answer offer(const std::optional<DetectedBoard>& found, const std::string& name);

  /// "the whole left side", "boards tilted up or down": what no view taken shows yet.
  const std::vector<std::string>& missing() const { return missing_; }
  /// Nothing is missing and there are enough views, or as many as may be.
  bool enough() const;
  /// What was taken.
  const CalibrationInput& input() const { return input_; }

 private:
  std::size_t missing_with(const BoardView& view) const;
  bool is_elsewhere(const DetectedBoard& found) const;

  Board board_;
  LiveAssistantOptions options_;
  CalibrationInput input_;
  std::optional<DetectedBoard> last_;
  Lens lens_;
  std::vector<std::string> missing_;
};

/// Mean distance of the corners that both have, pixels; infinite where they share less than half of those of `a`.
double board_motion(const DetectedBoard& a, const DetectedBoard& b);

}  // namespace rastro
