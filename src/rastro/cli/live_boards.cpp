// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/live_boards.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace rastro::cli {
namespace {

using Answer = LiveAssistant::Answer;

const char* state_of(Answer answer) {
  switch (answer) {
    case Answer::no_board:
      return "no_board";
    case Answer::moving:
      return "moving";
    case Answer::nothing_new:
      return "nothing_new";
    case Answer::one_camera:
      return "one_camera";
    case Answer::taken:
      return "taken";
  }
  return "no_board";
}

constexpr Answer answers[] = {Answer::no_board, Answer::moving, Answer::nothing_new, Answer::one_camera, Answer::taken};

std::vector<std::string> state_names() {
  std::vector<std::string> names;
  for (const Answer answer : answers) names.emplace_back(state_of(answer));
  return names;
}

LiveHello of_boards(LiveHello run) {
  run.has_poses = false;
  run.state_names = state_names();
  return run;
}

std::size_t state_number(Answer answer) {
  return static_cast<std::size_t>(std::find(std::begin(answers), std::end(answers), answer) - std::begin(answers));
}

/// "hold the board in the lower left", of what coverage names.
std::string request_for(const std::string& missing) {
  const auto colon = missing.rfind(": ");
  const std::string camera = colon == std::string::npos ? "" : " of the " + missing.substr(0, colon);
  const std::string what = colon == std::string::npos ? missing : missing.substr(colon + 2);
  if (what == "tilted boards") return "tilt the board by 20 to 45 degrees, to the sides and up and down";
  if (what.starts_with("boards tilted")) return "tilt the board by 20 to 45 degrees, " + what.substr(14);
  if (what.starts_with("boards at")) return "hold the board " + what.substr(7) + " of the nearest view, or nearer";
  if (what == "the whole image") return "hold the board still, each time elsewhere in the image" + camera;
  if (what.starts_with("everything")) return "hold the board away from the center of the image" + camera;
  if (what.starts_with("the whole ")) return "hold the board at the " + what.substr(10) + " of the image" + camera;
  return "hold the board in the " + what + " of the image" + camera;
}

GrayImage beside(const GrayImage& left, const GrayImage& right) {
  GrayImage both(left.width() + right.width(), std::max(left.height(), right.height()));
  for (int y = 0; y < left.height(); ++y) std::copy_n(left.row(y), left.width(), both.row(y));
  for (int y = 0; y < right.height(); ++y) std::copy_n(right.row(y), right.width(), both.row(y) + left.width());
  return both;
}

LiveFeatures corners_of(const FoundBoards& found, Answer answer, int width) {
  LiveFeatures features;
  features.state_names = {"corner", "taken"};
  for (std::size_t camera = 0; camera < found.size(); ++camera) {
    if (!found[camera]) continue;
    const auto shift = static_cast<float>(camera == 0 ? 0 : width);
    for (const Eigen::Vector2d& pixel : found[camera]->pixels)
      features.pixels.insert(features.pixels.end(),
                             {static_cast<float>(pixel.x()) + shift, static_cast<float>(pixel.y())});
  }
  features.states.assign(features.pixels.size() / 2, answer == Answer::taken ? 1 : 0);
  return features;
}

LiveCoverage coverage_of(const BoardCoverage& coverage, std::string camera) {
  LiveCoverage live;
  live.camera = std::move(camera);
  live.seen.assign(coverage.seen.begin(), coverage.seen.end());
  live.missing.assign(coverage.empty.begin(), coverage.empty.end());
  live.tilts_deg.assign(std::begin(coverage.largest_tilt_deg), std::end(coverage.largest_tilt_deg));
  return live;
}

LiveCalibration calibration_of(Answer answer, const LiveAssistant& assistant) {
  LiveCalibration live;
  live.line = board_advice(answer, assistant);
  live.views = assistant.views();
  live.enough_views = assistant.enough_views();
  live.enough = assistant.enough();
  live.wanted_tilt_deg = BoardCoverage::wanted_tilt_deg;
  live.missing = assistant.missing();
  const bool pair = assistant.input().stereo;
  live.cameras.push_back(coverage_of(assistant.coverage(0), pair ? "left" : ""));
  if (pair) live.cameras.push_back(coverage_of(assistant.coverage(1), "right"));
  for (const BoardView& view : assistant.input().views) {
    std::vector<float>& outline = live.outlines.emplace_back();
    const double shift = view.camera == 0 ? 0.0 : assistant.input().width;
    for (const Eigen::Vector2d& pixel : board_outline(view.pixels))
      outline.insert(outline.end(), {static_cast<float>(pixel.x() + shift), static_cast<float>(pixel.y())});
  }
  return live;
}

}  // namespace

std::string board_advice(Answer answer, const LiveAssistant& assistant) {
  if (assistant.enough()) return "enough: the camera is calibrated from these views";
  const auto& missing = assistant.missing();
  const std::string next =
      missing.empty() ? "hold the board elsewhere, or at another angle" : request_for(missing.front());
  switch (answer) {
    case Answer::no_board:
      return "no board is seen: " + next;
    case Answer::moving:
      return "hold it still";
    case Answer::one_camera:
      return "only one camera sees the board: hold it where both do";
    case Answer::nothing_new:
    case Answer::taken:
      break;
  }
  return next;
}

LiveBoards::LiveBoards(const ServerFlags& flags, LiveHello run, int cameras)
    : cameras_(cameras), sink_(flags, of_boards(std::move(run))) {}

void LiveBoards::show(const Frame& frame, const FoundBoards& found, Answer answer, const LiveAssistant& assistant) {
  ++done_;
  LiveFrame live;
  live.index = frame.index;
  live.stamp_s = to_seconds(frame.stamp);
  live.state = state_number(answer);
  live.used = static_cast<int>((found[0] ? found[0]->corners.size() : 0) + (found[1] ? found[1]->corners.size() : 0));
  live.score = std::numeric_limits<double>::quiet_NaN();  // it has none
  live.done = done_;
  if (answer == Answer::taken)
    live.events.emplace_back("view_taken", "view " + std::to_string(assistant.input().frames.size()));
  sink_.show(std::move(live));
  // A view that was taken is shown in any case, so that it is seen which one it was.
  if (sink_.is_watched() && (sink_.view().wants_image() || answer == Answer::taken)) show_image(frame, found, answer);
  sink_.view().show(calibration_of(answer, assistant));
  sink_.obey_pages();
}

void LiveBoards::show_image(const Frame& frame, const FoundBoards& found, Answer answer) {
  SeenImage seen;
  seen.frame.index = frame.index;
  seen.frame.stamp = frame.stamp;
  seen.frame.image = cameras_ > 1 ? beside(frame.image, frame.right) : frame.image;
  seen.features = corners_of(found, answer, frame.image.width());
  sink_.view().show(std::move(seen));
}

}  // namespace rastro::cli
