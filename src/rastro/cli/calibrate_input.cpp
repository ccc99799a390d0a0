// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/calibrate_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

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
    return detect_board(image.view(), board_);
  }

 private:
  const Board& board_;
  BoardImages& result_;
};

/// The next frame that can be read; unreadable ones are skipped with a warning.
std::optional<Frame> next_readable(Source& source) {
  for (;;) {
    try {
      return source.next();
    } catch (const UnusableSource&) {
      throw;
    } catch (const Error& error) {
      log_warning(error.what());
    }
  }
}

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

/// Both images of a frame, searched; the right one is of the second source, where there is one.
FoundBoard search_frame(BoardSearch& search, const Frame& frame, Source* right_source, const std::string& right) {
  FoundBoard now{frame.name, {search.search(frame.image, frame.name), std::nullopt}, {}};
  if (right_source != nullptr) {
    const auto right_frame = next_readable(*right_source);
    if (!right_frame) throw Error("has fewer images than DATA", right, "give one image for each of the left camera");
    now.corners[1] = search.search(right_frame->image, right_frame->name);
  } else if (!frame.right.empty()) {
    now.corners[1] = search.search(frame.right, frame.name);
  }
  return now;
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
  const std::string& right = search_for.right;
  const auto left_source = open_images(flags.path, open_options(flags), search_for);
  const std::unique_ptr<Source> right_source =
      right.empty() ? std::unique_ptr<Source>() : open_images(right, open_options(flags), {});
  BoardImages result;
  result.input.board = board.points();
  result.input.stereo = search_for.is_pair();
  result.depth_as_read = depth_as_read(left_source->info());
  BoardSearch search(board, result);
  std::vector<FoundBoard> found;
  const auto all = static_cast<std::size_t>(std::max<std::int64_t>(0, left_source->info().frame_count));
  for (std::size_t read = 0; auto frame = next_readable(*left_source); ++read) {
    stop_if_interrupted();
    FoundBoard now = search_frame(search, *frame, right_source.get(), right);
    if (board.kind == BoardKind::chessboard) order_like_left(now.corners);
    if (now.corners[0] || now.corners[1]) {
      if (near_known(now, found, least_motion * result.input.width)) {
        ++result.near_another;
      } else {
        if (now.corners[0]) now.depth = std::move(frame->depth);
        found.push_back(std::move(now));
        thin_depth(found);
      }
    }
    bar.show_steps("images", read + 1, std::max(all, read + 1));
  }
  add_views(found, search_for.most_views, result);
  return result;
}

}  // namespace rastro::cli
