// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/live_assistant.h"

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "rastro/calibration/board_start.h"

namespace rastro {
namespace {

/// Views from which the focal length is estimated anew; before, the angle of a usual lens is assumed.
constexpr std::size_t fewest_for_focal_length = 4, most_for_focal_length = 12;

/// Depth needs boards at distances that differ by so much, to tell its scale and its offset apart.
constexpr double wanted_distances = 2.0;

/// What the views of one camera show.
BoardCoverage coverage_of_camera(const CalibrationInput& input, const std::vector<BoardView>& views, int camera,
                                 const Lens& lens) {
  BoardSolution solution;
  BoardProblem& problem = solution.problem;
  problem.board = input.board;
  problem.lenses = {lens};
  for (const BoardView& view : views) {
    if (view.camera != camera) continue;
    const auto pose = board_pose(input.board, view, lens);
    if (!pose) continue;
    BoardView numbered = view;
    numbered.frame = static_cast<int>(problem.left_from_board.size());
    numbered.camera = 0;
    problem.left_from_board.push_back(*pose);
    problem.views.push_back(std::move(numbered));
  }
  return board_coverage(solution, 0, input.width, input.height);
}

/// What both lack, then what one of them does, with its name.
std::vector<std::string> joined(const std::vector<std::string>& left, const std::vector<std::string>& right) {
  const auto has = [](const std::vector<std::string>& list, const std::string& name) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  std::vector<std::string> all;
  for (const std::string& name : left)
    if (has(right, name)) all.push_back(name);
  for (const std::string& name : left)
    if (!has(right, name)) all.push_back("left camera: " + name);
  for (const std::string& name : right)
    if (!has(left, name)) all.push_back("right camera: " + name);
  return all;
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

std::vector<Eigen::Vector2d> board_outline(const std::vector<Eigen::Vector2d>& corners) {
  std::vector<cv::Point2f> points, hull, outline;
  for (const Eigen::Vector2d& corner : corners)
    points.emplace_back(static_cast<float>(corner.x()), static_cast<float>(corner.y()));
  if (points.empty()) return {};
  cv::convexHull(points, hull);
  constexpr double share_of_length = 0.01;
  cv::approxPolyDP(hull, outline, share_of_length * cv::arcLength(hull, true), true);
  std::vector<Eigen::Vector2d> result;
  for (const cv::Point2f& point : outline) result.emplace_back(point.x, point.y);
  return result;
}

void order_like_left(FoundBoards& found) {
  if (!found[0] || !found[1]) return;
  std::vector<Eigen::Vector2d>& right = found[1]->pixels;
  const Eigen::Vector2d along_left = found[0]->pixels.back() - found[0]->pixels.front();
  if (along_left.dot(right.back() - right.front()) < 0.0) std::reverse(right.begin(), right.end());
}

LiveAssistant::LiveAssistant(const Board& board, int width, int height, const LiveAssistantOptions& options)
    : board_(board), options_(options) {
  input_.board = board.points();
  input_.width = width;
  input_.height = height;
  input_.stereo = options.stereo;
  lenses_.fill(undistorted_lens(LensModel::pinhole_4, 0.9 * width, {0.5 * (width - 1), 0.5 * (height - 1)}));
  coverage_ = coverage_of({});
  missing_ = missing_in(coverage_);
}

LiveAssistant::Coverages LiveAssistant::coverage_of(const std::vector<BoardView>& views) const {
  Coverages coverage;
  for (std::size_t camera = 0; camera < cameras(); ++camera)
    coverage[camera] = coverage_of_camera(input_, views, static_cast<int>(camera), lenses_[camera]);
  return coverage;
}

bool LiveAssistant::lacks_distances(const Coverages& coverage) const {
  return options_.distances && (views_ == 0 || coverage[0].farthest_m < wanted_distances * coverage[0].nearest_m);
}

/// How much is missing, also where the names of what is missing become more: of a side, two corners remain.
std::size_t LiveAssistant::lacks(const Coverages& coverage) const {
  std::size_t count = lacks_distances(coverage) ? 1 : 0;
  for (std::size_t camera = 0; camera < cameras(); ++camera) {
    const BoardCoverage& of = coverage[camera];
    count += static_cast<std::size_t>(std::count(of.empty.begin(), of.empty.end(), true) +
                                      std::count(of.empty_edges.begin(), of.empty_edges.end(), true));
    count += (of.lacks_tilt_sideways ? 1U : 0U) + (of.lacks_tilt_up_down ? 1U : 0U);
  }
  return count;
}

std::vector<std::string> LiveAssistant::missing_in(const Coverages& coverage) const {
  std::vector<std::string> missing =
      options_.stereo ? joined(coverage[0].missing, coverage[1].missing) : coverage[0].missing;
  if (lacks_distances(coverage)) missing.emplace_back("boards at twice the distance");
  return missing;
}

bool LiveAssistant::is_still(const FoundBoards& before, const FoundBoards& found) const {
  const double most = std::max(1.0, options_.still_share * input_.width);
  for (std::size_t camera = 0; camera < cameras(); ++camera)
    if (found[camera] && (!before[camera] || board_motion(*found[camera], *before[camera]) > most)) return false;
  return true;
}

bool LiveAssistant::is_elsewhere(const FoundBoards& found) const {
  return std::all_of(input_.views.begin(), input_.views.end(), [&](const BoardView& taken) {
    const auto& now = found[static_cast<std::size_t>(taken.camera)];
    return !now || board_motion(*now, {taken.corners, taken.pixels}) > options_.new_share * input_.width;
  });
}

LiveAssistant::Answer LiveAssistant::offer(const FoundBoards& found, const std::string& name) {
  const FoundBoards before = std::exchange(last_, found);
  if (!found[0] && !found[1]) return Answer::no_board;
  if (!is_still(before, found)) return Answer::moving;
  if (!is_elsewhere(found)) return Answer::nothing_new;
  const bool whole = !options_.stereo || (found[0] && found[1]);
  std::vector<BoardView> views = input_.views;
  for (std::size_t camera = 0; camera < cameras(); ++camera)
    if (found[camera])
      views.push_back({static_cast<int>(input_.frames.size()), static_cast<int>(camera), found[camera]->corners,
                       found[camera]->pixels});
  // While much is missing, a view elsewhere that shows nothing of it only fills up the views.
  if ((!whole || views_ >= options_.enough_views) && lacks(coverage_of(views)) >= lacks(coverage_))
    return whole ? Answer::nothing_new : Answer::one_camera;
  input_.views = std::move(views);
  input_.frames.push_back(name);
  views_ += whole ? 1 : 0;
  estimate_lenses();
  coverage_ = coverage_of(input_.views);
  missing_ = missing_in(coverage_);
  return Answer::taken;
}

void LiveAssistant::estimate_lenses() {
  for (std::size_t camera = 0; camera < cameras(); ++camera) {
    std::vector<const BoardView*> all;
    for (const BoardView& view : input_.views)
      if (view.camera == static_cast<int>(camera)) all.push_back(&view);
    if (all.size() >= fewest_for_focal_length && all.size() <= most_for_focal_length)
      lenses_[camera] = start_boards(input_.board, all, LensModel::pinhole_4, input_.width, input_.height).lens;
  }
}

bool LiveAssistant::enough() const {
  return static_cast<int>(input_.frames.size()) >= options_.most_views ||
         (views_ >= options_.enough_views && missing_.empty());
}

}  // namespace rastro
