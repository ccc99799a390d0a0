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
  std::optional<DetectedBoard> corners[2];
  DepthImage depth;  ///< Where it is wanted.
};

bool near_known(const FoundBoard& found, const std::vector<FoundBoard>& known, double distance) {
  for (const FoundBoard& other : known)
    for (int camera = 0; camera < 2; ++camera)
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

/// The ends of a chessboard look alike: in both images of a pair the same one must be first.
void order_like_left(FoundBoard& found) {
  if (!found.corners[0] || !found.corners[1]) return;
  std::vector<Eigen::Vector2d>& right = found.corners[1]->pixels;
  const Eigen::Vector2d left_way = found.corners[0]->pixels.back() - found.corners[0]->pixels.front();
  if (left_way.dot(right.back() - right.front()) < 0.0) std::reverse(right.begin(), right.end());
}

std::unique_ptr<Source> open_images(const std::string& path, OpenOptions options, bool want_depth) {
  options.want_depth = want_depth;
  std::unique_ptr<Source> source = rastro::open(path, options);
  if (!source->info().has_image) throw Error("has no images", path, "give images, a video or a recording of a camera");
  if (want_depth && !source->info().has_depth)
    throw Error("has no depth", path, "omit --depth, or give a recording that has");
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
    for (int camera = 0; camera < 2; ++camera) {
      if (!board.corners[camera]) continue;
      input.views.push_back({frame, camera, board.corners[camera]->corners, board.corners[camera]->pixels});
    }
  }
}

}  // namespace

BoardImages find_boards(const DataFlags& flags, const Board& board, const BoardSearchOptions& search_for,
                        ProgressBar& bar) {
  const std::string& right = search_for.right;
  const auto left_source = open_images(flags.path, open_options(flags), search_for.want_depth);
  const std::unique_ptr<Source> right_source =
      right.empty() ? std::unique_ptr<Source>() : open_images(right, open_options(flags), false);
  BoardImages result;
  result.input.board = board.points();
  result.input.stereo = right_source != nullptr;
  result.depth_factor = left_source->info().depth_factor;
  BoardSearch search(board, result);
  std::vector<FoundBoard> found;
  const auto all = static_cast<std::size_t>(std::max<std::int64_t>(0, left_source->info().frame_count));
  for (std::size_t read = 0; auto frame = next_readable(*left_source); ++read) {
    stop_if_interrupted();
    FoundBoard now{frame->name, {search.search(frame->image, frame->name), std::nullopt}, {}};
    if (right_source) {
      const auto right_frame = next_readable(*right_source);
      if (!right_frame) throw Error("has fewer images than DATA", right, "give one image for each of the left camera");
      now.corners[1] = search.search(right_frame->image, right_frame->name);
    }
    if (board.kind == BoardKind::chessboard) order_like_left(now);
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
