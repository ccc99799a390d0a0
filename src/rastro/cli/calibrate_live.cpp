// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
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
    auto arrived = next_of(*left_, patience);
    if (!arrived || !right_) return arrived ? std::optional(std::move(arrived->frame)) : std::nullopt;
    while (auto newer = next_of(*right_, 0)) newest_right_ = std::move(newer);
    if (!newest_right_ || std::abs(newest_right_->exposed - arrived->exposed) > longest_apart) return std::nullopt;
    arrived->frame.right = newest_right_->frame.image;
    return std::move(arrived->frame);
  }

 private:
  /// A frame that cannot be read is passed over.
  static std::optional<ArrivedFrame> next_of(LiveSource& source, TimeNs at_most) {
    try {
      return source.next(at_most);
    } catch (const UnusableSource&) {
      throw;
    } catch (const Error& error) {
      log_warning(error.what());
      return std::nullopt;
    }
  }

  SteadyClock clock_;
  std::unique_ptr<LiveSource> left_, right_;
  std::optional<ArrivedFrame> newest_right_;
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
    const LiveAssistant::Answer answer = assistant->offer(found, frame->name);
    if (page != nullptr) page->show(*frame, found, answer, *assistant);
    if (answer != LiveAssistant::Answer::taken) continue;
    result.depths.push_back(found[0] ? std::move(frame->depth) : DepthImage());
    speaker.taken(*assistant);
  }
  if (!assistant) throw Error("gave no image", flags.path, "'rastro devices' lists what is connected");
  result.input = assistant->input();
  result.depth_factor = images.info().depth_factor;
  return result;
}

}  // namespace rastro::cli
