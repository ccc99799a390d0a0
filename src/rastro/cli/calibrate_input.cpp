// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/calibrate_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/calibration/live_assistant.h"
#include "rastro/cli/interrupt.h"
#include "rastro/dataset/open.h"

namespace rastro::cli {
namespace {

/// Boards that moved by less than this share of the image's width since another view tell nothing new.
constexpr double least_motion = 0.01;

/// One moment: where the board is in one image or both.
struct FoundBoard {
  std::string name;
  FoundBoards corners;
  DepthImage depth;  ///< Where it is wanted.
};

bool near_known(const FoundBoard& found, const std::vector<FoundBoard>& known, double distance) {
  for (const FoundBoard& other : known)
    for (const std::size_t camera : {0U, 1U})
      if (found.corners[camera] && other.corners[camera] &&
          board_motion(*found.corners[camera], *other.corners[camera]) < distance)
        return true;
  return false;
}

class BoardSearch {
 public:
  BoardSearch(const Board& board, BoardImages& result) : board_(board), result_(result) {}

  std::optional<DetectedBoard> search(const GrayImage& image, const std::string& name) {
    CalibrationInput& input = result_.input;
    if (input.width == 0) {
      input.width = image.width();
      input.height = image.height();
    } else if (image.width() != input.width || image.height() != input.height) {
      throw Error(fmt::format("is {}x{} pixels, the images before are {}x{}", image.width(), image.height(),
                              input.width, input.height),
                  name, "calibrate with images of one size");
    }
    ++result_.images;
    auto found = detect_board(image.view(), board_);
    result_.found += found ? 1 : 0;
    return found;
  }

 private:
  const Board& board_;
  BoardImages& result_;
};

/// The images of a source that can be read; the others are passed over with a warning.
class ReadableImages {
 public:
  explicit ReadableImages(std::unique_ptr<Source> source) : source_(std::move(source)) {}

  const SourceInfo& info() const { return source_->info(); }

  std::optional<Frame> next() {
    for (;;) {
      try {
        auto frame = source_->next();
        passed_ += frame ? 1 : 0;
        return frame;
      } catch (const UnusableSource&) {
        throw;
      } catch (const Error& error) {
        ++passed_;
        log_warning(error.what());
      }
    }
  }
  /// How many came, readable or not.
  std::int64_t passed() const { return passed_; }

 private:
  std::unique_ptr<Source> source_;
  std::int64_t passed_ = 0;
};

/// The images of a right camera that has a source of its own, each beside the left one of its number.
class RightImages {
 public:
  RightImages(std::unique_ptr<Source> source, std::string path) : images_(std::move(source)), path_(std::move(path)) {}

  /// nullopt: that image cannot be read. `left`: those of the left camera up to this one.
  std::optional<Frame> beside(const Frame& frame, const ReadableImages& left) {
    while (!ended_ && (!next_ || next_->index < frame.index)) {
      next_ = images_.next();
      ended_ = !next_;
    }
    if (ended_ && images_.passed() < left.passed())
      throw Error("has fewer images than DATA", path_, "give one image for each of the left camera");
    if (!next_ || next_->index > frame.index) return std::nullopt;
    return std::exchange(next_, std::nullopt);
  }

  /// At the end of the left ones.
  void require_no_more(const ReadableImages& left) {
    while (images_.passed() <= left.passed() && images_.next()) {
    }
    if (images_.passed() > left.passed())
      throw Error("has more images than DATA", path_, "give one image for each of the left camera");
  }

 private:
  ReadableImages images_;
  std::string path_;
  std::optional<Frame> next_;  ///< Read, not yet asked for.
  bool ended_ = false;
};

std::unique_ptr<Source> open_images(const std::string& path, OpenOptions options,
                                    const BoardSearchOptions& search_for) {
  options.want_depth = search_for.want_depth;
  options.raw_depth = search_for.raw_depth;
  options.want_right = search_for.stereo;
  std::unique_ptr<Source> source = rastro::open(path, options);
  if (!source->info().has_image) throw Error("has no images", path, "give images, a video or a recording of a camera");
  require_images(source->info(), search_for);
  return source;
}

/// Depth images are large: from this many on, every other one goes.
constexpr std::size_t most_depth_images = 200;

void thin_depth(std::vector<FoundBoard>& found) {
  std::size_t kept = 0;
  for (const FoundBoard& board : found) kept += board.depth.empty() ? 0 : 1;
  if (kept <= most_depth_images) return;
  std::size_t number = 0;
  for (FoundBoard& board : found)
    if (!board.depth.empty() && number++ % 2 == 1) board.depth = {};
}

void add_views(std::vector<FoundBoard>& found, std::size_t most, BoardImages& result) {
  CalibrationInput& input = result.input;
  const std::size_t count = std::min(most, found.size());
  for (std::size_t k = 0; k < count; ++k) {
    FoundBoard& board = found[k * found.size() / count];
    const int frame = static_cast<int>(input.frames.size());
    input.frames.push_back(board.name);
    result.depths.push_back(std::move(board.depth));
    for (const std::size_t camera : {0U, 1U}) {
      if (!board.corners[camera]) continue;
      input.views.push_back(
          {frame, static_cast<int>(camera), board.corners[camera]->corners, board.corners[camera]->pixels});
    }
  }
}

/// Both images of a frame, searched. `right_frame`: of a right camera that has a source of its own.
FoundBoard search_frame(BoardSearch& search, const Frame& frame, const std::optional<Frame>& right_frame) {
  FoundBoard now{frame.name, {search.search(frame.image, frame.name), std::nullopt}, {}};
  if (right_frame) {
    now.corners[1] = search.search(right_frame->image, right_frame->name);
  } else if (!frame.right.empty()) {
    now.corners[1] = search.search(frame.right, frame.name);
  }
  return now;
}

/// Kept where it tells something new.
void add_found(FoundBoard now, DepthImage depth, std::vector<FoundBoard>& found, BoardImages& result) {
  if (!now.corners[0] && !now.corners[1]) return;
  if (near_known(now, found, least_motion * result.input.width)) {
    ++result.near_another;
    return;
  }
  if (now.corners[0]) now.depth = std::move(depth);
  found.push_back(std::move(now));
  thin_depth(found);
}

}  // namespace

DepthAsRead depth_as_read(const SourceInfo& info) {
  return {info.depth_factor, info.depth_offset_m, info.depth_registration};
}

void require_images(const SourceInfo& info, const BoardSearchOptions& search_for) {
  if (search_for.stereo && !info.has_right)
    throw Error("has no right images", info.path, "give those of the right camera with --right");
  if (search_for.want_depth && !info.has_depth)
    throw Error("has no depth", info.path, "omit --depth, or give a recording that has");
}

BoardImages find_boards(const DataFlags& flags, const Board& board, const BoardSearchOptions& search_for,
                        ProgressBar& bar) {
  ReadableImages left(open_images(flags.path, open_options(flags), search_for));
  std::optional<RightImages> right;
  if (!search_for.right.empty())
    right.emplace(open_images(search_for.right, open_options(flags), {}), search_for.right);
  BoardImages result;
  result.input.board = board.points();
  result.input.stereo = search_for.is_pair();
  result.depth_as_read = depth_as_read(left.info());
  BoardSearch search(board, result);
  std::vector<FoundBoard> found;
  const auto all = static_cast<std::size_t>(std::max<std::int64_t>(0, left.info().frame_count));
  for (std::size_t read = 0; auto frame = left.next(); ++read) {
    stop_if_interrupted();
    FoundBoard now = search_frame(search, *frame, right ? right->beside(*frame, left) : std::nullopt);
    if (board.kind == BoardKind::chessboard) order_like_left(now.corners);
    add_found(std::move(now), std::move(frame->depth), found, result);
    bar.show_steps("images", read + 1, std::max(all, read + 1));
  }
  if (right) right->require_no_more(left);
  add_views(found, search_for.most_views, result);
  return result;
}

}  // namespace rastro::cli
