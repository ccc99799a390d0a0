// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <deque>
#include <memory>
#include <optional>

#include "rastro/base/clock.h"
#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/calibration/live_assistant.h"
#include "rastro/cli/calibrate_input.h"
#include "rastro/cli/interrupt.h"
#include "rastro/cli/live_boards.h"
#include "rastro/dataset/live/live.h"

namespace rastro::cli {
namespace {

constexpr TimeNs patience = 100'000'000;
/// Between the images of two cameras that know nothing of each other, at 10 images a second; the board is held still.
constexpr TimeNs longest_apart = 100'000'000;

OpenOptions live_options(const DataFlags& flags, const BoardSearchOptions& search_for) {
  OpenOptions options = open_options(flags);
  options.want_right = search_for.stereo;
  options.want_depth = search_for.want_depth;
  options.raw_depth = search_for.raw_depth;
  return options;
}

/// The images of a live source, or of two side by side.
class LiveImages {
 public:
  LiveImages(const DataFlags& flags, const BoardSearchOptions& search_for)
      : left_(open_live(flags.path, live_options(flags, search_for), {}, clock_, &catch_interrupts())) {
    require_images(left_->info(), search_for);
    if (!search_for.right.empty())
      right_ = open_live(search_for.right, live_options(flags, {}), {}, clock_, &catch_interrupts());
  }

  const SourceInfo& info() const { return left_->info(); }
  LiveCondition condition() const {
    const LiveCondition left = left_->condition();
    return right_ && left.state == LiveState::delivering ? right_->condition() : left;
  }

  /// nullopt: none came, or none that belong together.
  std::optional<Frame> next() {
    auto left = next_of(*left_, patience);
    if (!left || !right_) return left;
    // The next right image may be nearer than the last one.
    while (right_frames_.empty() || right_frames_.back().stamp < left->stamp) {
      auto right = next_of(*right_, longest_apart / 2);
      if (!right) break;
      right_frames_.push_back(std::move(*right));
      if (right_frames_.size() > most_right) right_frames_.pop_front();
    }
    const auto distance = [&](const Frame& right) { return std::abs(right.stamp - left->stamp); };
    while (right_frames_.size() > 1 && distance(right_frames_[1]) <= distance(right_frames_[0]))
      right_frames_.pop_front();
    if (right_frames_.empty() || distance(right_frames_.front()) > longest_apart) {
      note_apart();
      return std::nullopt;
    }
    apart_ = 0;
    left->right = right_frames_.front().image;
    return left;
  }

 private:
  static constexpr std::size_t most_right = 32;

  /// A frame that cannot be read is passed over.
  static std::optional<Frame> next_of(LiveSource& source, TimeNs at_most) {
    try {
      auto arrived = source.next(at_most);
      return arrived ? std::optional(std::move(arrived->frame)) : std::nullopt;
    } catch (const UnusableSource&) {
      throw;
    } catch (const Error& error) {
      log_warning(error.what());
      return std::nullopt;
    }
  }

  void note_apart() {
    constexpr int many = 100;
    if (++apart_ == many)
      log_warning(
          fmt::format("no image of --right is within {:g} s of those of DATA: are both on, and their clocks the same?",
                      to_seconds(longest_apart)));
  }

  SteadyClock clock_;
  std::unique_ptr<LiveSource> left_, right_;
  std::deque<Frame> right_frames_;
  int apart_ = 0;  ///< Images of the left camera in a row without one of the right camera.
};

/// Says what changes, not what stays as it is.
class Speaker {
 public:
  explicit Speaker(bool quiet) : quiet_(quiet) {}

  void condition(const LiveCondition& condition) {
    if (condition.line != condition_ && !condition.line.empty()) log_warning(condition.line);
    condition_ = condition.line;
  }
  void taken(const LiveAssistant& assistant) const {
    if (quiet_) return;
    const auto& missing = assistant.missing();
    fmt::print(stderr, "view {} taken{}\n", assistant.input().frames.size(),
               missing.empty() ? std::string("; nothing is missing, more views make it surer")
                               : fmt::format("; missing: {}", fmt::join(missing, ", ")));
  }

 private:
  bool quiet_;
  std::string condition_;
};

LiveAssistant assistant_for(const Frame& frame, const Board& board, const BoardSearchOptions& search_for) {
  LiveAssistantOptions options;
  options.most_views = static_cast<int>(search_for.most_views);
  options.enough_views = std::min(options.enough_views, options.most_views);
  options.stereo = search_for.is_pair();
  options.distances = search_for.want_depth;
  return {board, frame.image.width(), frame.image.height(), options};
}

void require_size(const GrayImage& image, const LiveAssistant& assistant, const std::string& path) {
  if (image.width() != assistant.input().width || image.height() != assistant.input().height)
    throw Error("changes the size of its images, or that of the right camera is another one", path,
                "calibrate with images of one size");
}

FoundBoards search(const Frame& frame, const Board& board) {
  FoundBoards found{detect_board(frame.image.view(), board), std::nullopt};
  if (!frame.right.empty()) found[1] = detect_board(frame.right.view(), board);
  if (board.kind == BoardKind::chessboard) order_like_left(found);
  return found;
}

/// Whether the frame has all that a view needs.
bool is_complete(const Frame& frame, const BoardSearchOptions& search_for) {
  return !(search_for.is_pair() && frame.right.empty()) && !(search_for.want_depth && frame.depth.empty());
}

}  // namespace

BoardImages find_boards_live(const DataFlags& flags, const Board& board, const BoardSearchOptions& search_for,
                             LiveBoards* page) {
  const std::atomic<bool>& stop = catch_interrupts();
  LiveImages images(flags, search_for);
  Speaker speaker(flags.quiet);
  BoardImages result;
  std::optional<LiveAssistant> assistant;
  while (!stop && !(assistant && assistant->enough())) {
    auto frame = images.next();
    speaker.condition(images.condition());
    if (!frame && images.condition().state == LiveState::ended) break;
    if (!frame && page != nullptr) page->idle(images.condition().line);
    if (!frame || !is_complete(*frame, search_for)) continue;
    if (!assistant) assistant = assistant_for(*frame, board, search_for);
    require_size(frame->image, *assistant, flags.path);
    if (search_for.is_pair()) require_size(frame->right, *assistant, flags.path);
    result.images += search_for.is_pair() ? 2 : 1;
    const FoundBoards found = search(*frame, board);
    result.found += (found[0] ? 1 : 0) + (found[1] ? 1 : 0);
    const LiveAssistant::Answer answer = assistant->offer(found, frame->name);
    if (page != nullptr) page->show(*frame, found, answer, *assistant);
    if (answer != LiveAssistant::Answer::taken) continue;
    result.depths.push_back(found[0] ? std::move(frame->depth) : DepthImage());
    speaker.taken(*assistant);
  }
  if (!assistant) throw Error("gave no image", flags.path, "'rastro devices' lists what is connected");
  result.input = assistant->input();
  result.depth_as_read = depth_as_read(images.info());
  return result;
}

}  // namespace rastro::cli
