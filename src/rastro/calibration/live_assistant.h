// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "rastro/calibration/board_detector.h"
#include "rastro/calibration/calibrate.h"
#include "rastro/calibration/trust.h"

namespace rastro {

struct LiveAssistantOptions {
  int enough_views = 20;  ///< Of a pair: that both cameras see.
  int most_views = 100;
  double still_share = 0.004;  ///< Of the image's width: a board that moved less since the last image is held still.
  double new_share = 0.06;     ///< A board whose corners are this far from those of every view taken is elsewhere.
  bool stereo = false;         ///< A pair: a board that one camera sees is taken only for what that camera lacks.
  bool distances = false;      ///< Boards near and far are wanted, as the calibration of depth needs them.
};

/// The board in the image of one camera, or in those of the left and the right one at the same moment.
using FoundBoards = std::array<std::optional<DetectedBoard>, 2>;

/// Chooses views of a board from a live camera: sharp ones, since the board is held still, that show what is missing.
class LiveAssistant {
 public:
  enum class Answer {
    no_board,
    moving,       ///< Blurred, or soon to be.
    nothing_new,  ///< Such a view was taken.
    one_camera,   ///< Of a pair: the other camera does not see the board, and this one lacks nothing of it.
    taken,
  };

  LiveAssistant(const Board& board, int width, int height, const LiveAssistantOptions& options = {});

  /// The next image or pair of images: what was found in them, and their name.
  Answer offer(const FoundBoards& found, const std::string& name);

  /// "the whole left side", "boards tilted up or down": what no view taken shows yet. Of a pair with the camera, where
  /// the other one has it.
  const std::vector<std::string>& missing() const { return missing_; }
  /// What the views taken show to a camera: 0, or 1 for the right one.
  const BoardCoverage& coverage(std::size_t camera) const { return coverage_[camera]; }
  /// Views taken that count: of a pair those that both cameras see.
  int views() const { return views_; }
  int enough_views() const { return options_.enough_views; }
  /// Nothing is missing and there are enough views, or as many as may be.
  bool enough() const;
  /// What was taken.
  const CalibrationInput& input() const { return input_; }

 private:
  using Coverages = std::array<BoardCoverage, 2>;

  std::size_t cameras() const { return options_.stereo ? 2 : 1; }
  bool is_still(const FoundBoards& before, const FoundBoards& found) const;
  bool is_elsewhere(const FoundBoards& found) const;
  Coverages coverage_of(const std::vector<BoardView>& views) const;
  std::size_t lacks(const Coverages& coverage) const;
  bool lacks_distances(const Coverages& coverage) const;
  std::vector<std::string> missing_in(const Coverages& coverage) const;
  void estimate_lenses();

  Board board_;
  LiveAssistantOptions options_;
  CalibrationInput input_;
  FoundBoards last_;
  std::array<Lens, 2> lenses_;
  int views_ = 0;
  Coverages coverage_;
  std::vector<std::string> missing_;
};

/// Mean distance of the corners that both have, pixels; infinite where they share less than half of those of `a`.
double board_motion(const DetectedBoard& a, const DetectedBoard& b);

/// The polygon around corners, in order; at most about a dozen of them.
std::vector<Eigen::Vector2d> board_outline(const std::vector<Eigen::Vector2d>& corners);

/// The ends of a chessboard look alike: turns the right corners so that in both images of a pair the same one is first.
void order_like_left(FoundBoards& found);

}  // namespace rastro
