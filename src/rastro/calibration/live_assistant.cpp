// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/live_assistant.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "rastro/calibration/board_start.h"
#include "rastro/calibration/trust.h"

namespace rastro {
namespace {

/// Views from which the focal length is estimated anew; before, the angle of a usual lens is assumed.
constexpr std::size_t fewest_for_focal_length = 4, most_for_focal_length = 12;

/// What is missing in these views.
BoardCoverage coverage_of(const CalibrationInput& input, const std::vector<BoardView>& views, const Lens& lens) {
  BoardSolution solution;
  BoardProblem& problem = solution.problem;
  problem.board = input.board;
  problem.lenses = {lens};
  for (const BoardView& view : views) {
    const auto pose = board_pose(input.board, view, lens);
    if (!pose) continue;
    BoardView numbered = view;
    numbered.frame = static_cast<int>(problem.left_from_board.size());
    problem.left_from_board.push_back(*pose);
    problem.views.push_back(std::move(numbered));
  }
  return board_coverage(solution, 0, input.width, input.height);
}

}  // namespace

double board_motion(const DetectedBoard& a, const DetectedBoard& b) {
  double sum = 0.0;
  std::size_t shared = 0;
  for (std::size_t i = 0, j = 0; i < a.corners.size() && j < b.corners.size();) {
    if (a.corners[i] == b.corners[j]) {
      sum += (a.pixels[i++] - b.pixels[j++]).norm();
      ++shared;
    } else {
      (a.corners[i] < b.corners[j] ? i : j)++;
    }
  }
  if (shared == 0 || 2 * shared < a.corners.size()) return std::numeric_limits<double>::infinity();
  return sum / static_cast<double>(shared);
}

LiveAssistant::LiveAssistant(const Board& board, int width, int height, const LiveAssistantOptions& options)
    : board_(board), options_(options) {
  input_.board = board.points();
  input_.width = width;
  input_.height = height;
  lens_ = undistorted_lens(LensModel::pinhole_4, 0.9 * width, {0.5 * (width - 1), 0.5 * (height - 1)});
  missing_ = coverage_of(input_, {}, lens_).missing;
}

std::size_t LiveAssistant::missing_with(const BoardView& view) const {
  std::vector<BoardView> views = input_.views;
  views.push_back(view);
  return coverage_of(input_, views, lens_).missing.size();
}

bool LiveAssistant::is_elsewhere(const DetectedBoard& found) const {
  return std::all_of(input_.views.begin(), input_.views.end(), [&](const BoardView& taken) {
    return board_motion(found, {taken.corners, taken.pixels}) > options_.new_share * input_.width;
  });
}

LiveAssistant::Answer LiveAssistant::offer(const std::optional<DetectedBoard>& found, const std::string& name) {
  const std::optional<DetectedBoard> before = std::exchange(last_, found);
  if (!found) return Answer::no_board;
  if (!before || board_motion(*found, *before) > std::max(1.0, options_.still_share * input_.width))
    return Answer::moving;
  BoardView view{static_cast<int>(input_.frames.size()), 0, found->corners, found->pixels};
  if (!is_elsewhere(*found)) return Answer::nothing_new;
  // While much is missing, a view elsewhere that shows nothing of it only fills up the views.
  const bool many = static_cast<int>(input_.views.size()) >= options_.enough_views;
  if (many && missing_with(view) >= missing_.size()) return Answer::nothing_new;
  input_.views.push_back(std::move(view));
  input_.frames.push_back(name);
  if (input_.views.size() >= fewest_for_focal_length && input_.views.size() <= most_for_focal_length) {
    std::vector<const BoardView*> all;
    for (const BoardView& each : input_.views) all.push_back(&each);
    lens_ = start_boards(input_.board, all, LensModel::pinhole_4, input_.width, input_.height).lens;
  }
  missing_ = coverage_of(input_, input_.views, lens_).missing;
  return Answer::taken;
}

bool LiveAssistant::enough() const {
  const auto taken = static_cast<int>(input_.views.size());
  return taken >= options_.most_views || (taken >= options_.enough_views && missing_.empty());
}

}  // namespace rastro
