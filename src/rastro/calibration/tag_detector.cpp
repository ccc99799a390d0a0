// SPDX-License-Identifier: Apache-2.0
// Boards with tags: ChArUco boards and grids of AprilTags.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "rastro/calibration/board_dictionary.h"
#include "rastro/calibration/board_image.h"
#include "rastro/calibration/tag_quads.h"

namespace rastro {
namespace {

constexpr int search_size = 1000;
constexpr std::size_t fewest_corners = 6;
/// Of the side of a tag: where its neighbors may be off from where it says, by perspective that its own corners tell
/// badly and by the lens. A tag that was misread is off by a whole side or more.
constexpr double neighbor_tolerance = 0.4;
/// Farther from where the tags say that it is, what was found is another corner; pixels.
constexpr double most_off = 1.5;

/// Tags by their number on the board, corners clockwise from the upper left.
using FoundTags = std::map<int, TagQuad>;

/// From the board's plane to the image, as the corners of one tag say.
cv::Matx33d image_from_board(const BoardTag& tag, double side, const TagQuad& corners) {
  const cv::Matx33d square_from_board(1.0 / side, 0.0, -tag.upper_left.x() / side,  //
                                      0.0, 1.0 / side, -tag.upper_left.y() / side,  //
                                      0.0, 0.0, 1.0);
  return image_from_square(corners) * square_from_board;
}

/// How the tags of a board are read.
struct TagReader {
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  int tag_count;
  int border_cells;
};

FoundTags read_tags(const cv::Mat& image, const std::vector<TagQuad>& quads, const TagReader& reader) {
  FoundTags found;
  for (const TagQuad& quad : quads) {
    const auto tag = read_tag(image, quad, *reader.dictionary, reader.border_cells);
    if (tag && tag->id < reader.tag_count) found.try_emplace(tag->id, turned(quad, tag->turns));
  }
  return found;
}

/// Whether one of the nearest other tags is where this one says.
bool agrees(int number, const FoundTags& found, const std::vector<BoardTag>& tags, const Board& board) {
  const auto at = [&](int n) -> const BoardTag& { return tags[static_cast<std::size_t>(n)]; };
  const TagQuad& quad = found.at(number);
  const cv::Matx33d homography = image_from_board(at(number), board.tag_m, quad);
  const double half = 0.5 * board.tag_m;
  for (const auto& [other, corners] : found) {
    if (other == number || (at(other).upper_left - at(number).upper_left).norm() > 2.1 * board.square_m) continue;
    const cv::Point2f said = mapped(homography, at(other).upper_left.x() + half, at(other).upper_left.y() + half);
    if (cv::norm(said - center_of(corners)) <
        neighbor_tolerance * std::max(shortest_side(quad), shortest_side(corners)))
      return true;
  }
  return false;
}

/// Tags of a board in an image.
struct BoardTags {
  FoundTags found;
  std::size_t turns = 0;  ///< By which each is turned on the board: printed grids have all tags turned alike.
};

/// Without tags that were misread, and with the first corner where the board has it.
BoardTags agreeing(const FoundTags& found, const std::vector<BoardTag>& tags, const Board& board) {
  BoardTags best;
  const std::size_t most_turns = board.kind == BoardKind::apriltag ? 4 : 1;
  for (std::size_t turns = 0; turns < most_turns; ++turns) {
    FoundTags all, good;
    for (const auto& [number, quad] : found) all[number] = turned(quad, turns);
    for (const auto& [number, quad] : all)
      if (agrees(number, all, tags, board)) good[number] = quad;
    if (good.size() > best.found.size()) best = {std::move(good), turns};
  }
  return best;
}

/// Where a tag should be, as the tags beside it say; nullopt where there are none.
std::optional<TagQuad> predicted_tag(const BoardTag& tag, const FoundTags& found, const std::vector<BoardTag>& tags,
                                     const Board& board, double reach) {
  std::vector<cv::Point2d> flat, seen;
  const auto corners_of = [&](const BoardTag& of) {
    const double x = of.upper_left.x(), y = of.upper_left.y(), s = board.tag_m;
    return std::array<cv::Point2d, 4>{{{x, y}, {x + s, y}, {x + s, y + s}, {x, y + s}}};
  };
  for (const auto& [number, quad] : found) {
    const BoardTag& other = tags[static_cast<std::size_t>(number)];
    if ((other.upper_left - tag.upper_left).norm() > reach * board.square_m) continue;
    for (const cv::Point2d& corner : corners_of(other)) flat.push_back(corner);
    seen.insert(seen.end(), quad.begin(), quad.end());
  }
  if (flat.empty()) return std::nullopt;
  const cv::Mat homography = cv::findHomography(flat, seen);
  if (homography.empty()) return std::nullopt;
  const auto corners = corners_of(tag);
  TagQuad quad;
  std::transform(corners.begin(), corners.end(), quad.begin(), [&](const cv::Point2d& corner) {
    return mapped(cv::Matx33d(homography.ptr<double>()), corner.x, corner.y);
  });
  return quad;
}

bool inside(const TagQuad& quad, const cv::Mat& image) {
  const auto width = static_cast<float>(image.cols), height = static_cast<float>(image.rows);
  return std::all_of(quad.begin(), quad.end(), [&](const cv::Point2f& corner) {
    return corner.x >= 0.0F && corner.y >= 0.0F && corner.x < width && corner.y < height;
  });
}

/// Reads tags that were overlooked where the tags beside them say that they are: only the board's own counts there.
void add_overlooked(const cv::Mat& image, const std::vector<BoardTag>& tags, const Board& board,
                    const TagReader& reader, BoardTags& all) {
  for (std::size_t before = 0; before < all.found.size();) {
    before = all.found.size();
    FoundTags more;
    for (const BoardTag& tag : tags) {
      if (all.found.contains(tag.id)) continue;
      const auto quad = predicted_tag(tag, all.found, tags, board, 2.1);
      if (!quad || !inside(*quad, image)) continue;
      const auto read = read_tag(image, *quad, *reader.dictionary, reader.border_cells);
      if (read && read->id == tag.id && (read->turns + all.turns) % 4 == 0) more[tag.id] = *quad;
    }
    all.found.merge(more);
  }
}

/// Each tag where it and the tags beside it say that it is: outlines are a pixel off where corners are acute, and the
/// search for a corner would end at another one.
FoundTags smoothed(const FoundTags& found, const std::vector<BoardTag>& tags, const Board& board) {
  FoundTags result;
  for (const auto& [number, quad] : found)
    result[number] = predicted_tag(tags[static_cast<std::size_t>(number)], found, tags, board, 1.5).value_or(quad);
  return result;
}

/// Where a corner should be, and half the window that holds no other edge; pixels.
struct Expected {
  cv::Point2f pixel;
  float half_window = 0.0F;
};

/// A corner between squares: the mean of what the two tags beside it say.
std::map<int, Expected> expected_squares(const FoundTags& found, const std::vector<BoardTag>& tags,
                                         const Board& board) {
  const std::vector<Eigen::Vector2d> points = board.points();
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(0.5 * board.tag_m);
  const auto gap_share = static_cast<float>(0.5 * (board.square_m - board.tag_m) / board.tag_m);
  std::map<int, Expected> expected;
  for (std::size_t corner = 0; corner < points.size(); ++corner) {
    cv::Point2f sum(0.0F, 0.0F);
    float side = 1e9F;
    int beside = 0;
    for (const auto& [number, quad] : found) {
      const BoardTag& tag = tags[static_cast<std::size_t>(number)];
      if ((tag.upper_left + half - points[corner]).lpNorm<Eigen::Infinity>() > 0.6 * board.square_m) continue;
      sum += mapped(image_from_board(tag, board.tag_m, quad), points[corner].x(), points[corner].y());
      side = std::min(side, narrowest_width(quad));
      ++beside;
    }
    if (beside == 2) expected[static_cast<int>(corner)] = {sum * 0.5F, side * gap_share};
  }
  return expected;
}

std::map<int, Expected> expected_tag_corners(const FoundTags& found, const Board& board, int border_cells) {
  const double cells = static_cast<double>(tag_cells(board.tags, 0).size()) + 2.0 * (border_cells - 1);
  const auto share = static_cast<float>(
      std::min((board.square_m - board.tag_m) / board.tag_m, static_cast<double>(border_cells) / cells));
  std::map<int, Expected> expected;
  for (const auto& [number, quad] : found)
    for (int k = 0; k < 4; ++k)
      expected[4 * number + k] = {quad[static_cast<std::size_t>(k)], narrowest_width(quad) * share};
  return expected;
}

/// Smallest and largest extent of points of the board may differ, but both must be there.
bool spread_out(const std::vector<int>& corners, const std::vector<Eigen::Vector2d>& points, double square) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const int corner : corners)
    mean += points[static_cast<std::size_t>(corner)] / static_cast<double>(corners.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const int corner : corners) {
    const Eigen::Vector2d off = points[static_cast<std::size_t>(corner)] - mean;
    scatter += off * off.transpose() / static_cast<double>(corners.size());
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvalues()[0] > 0.04 * square * square;
}

DetectedBoard refined(const cv::Mat& full, int factor, const std::map<int, Expected>& expected) {
  const cv::TermCriteria stop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 40, 1e-3);
  DetectedBoard result;
  for (const auto& [corner, from] : expected) {
    const int half = std::clamp(static_cast<int>(0.9F * from.half_window * static_cast<float>(factor)), 2, 11);
    std::vector<cv::Point2f> at = {in_full_image(from.pixel, factor)};
    const auto inside = [&](const cv::Point2f& p) {
      const auto margin = static_cast<float>(half);
      return p.x >= margin && p.y >= margin && p.x < static_cast<float>(full.cols) - margin &&
             p.y < static_cast<float>(full.rows) - margin;
    };
    const cv::Point2f before = at.front();
    if (!inside(before)) continue;
    cv::cornerSubPix(full, at, {half, half}, {-1, -1}, stop);
    // It stays where it was when it does not converge.
    if (!inside(at.front()) || at.front() == before || cv::norm(at.front() - before) > most_off * factor) continue;
    result.corners.push_back(corner);
    result.pixels.emplace_back(at.front().x, at.front().y);
  }
  return result;
}

/// Tags found in an image reduced by `factor`.
struct Search {
  FoundTags tags;
  int factor = 1;
  int border_cells = 1;
};

Search search_image(const cv::Mat& full, const Board& board, const std::vector<BoardTag>& tags) {
  Search best;
  const int largest = std::max(full.cols, full.rows);
  // Kalibr's tags have a border of two cells.
  const int most_border = board.kind == BoardKind::apriltag ? 2 : 1;
  const auto dictionary = cv::aruco::getPredefinedDictionary(dictionary_number(board.tags).value_or(0));
  for (int factor = std::max(1, (largest + search_size / 2) / search_size);; factor = (factor + 1) / 2) {
    const cv::Mat small = reduced_image(full, factor);
    const std::vector<TagQuad> quads = dark_quads(small);
    for (int border = 1; border <= most_border && best.tags.size() < 2; ++border) {
      const TagReader reader{dictionary, static_cast<int>(tags.size()), border};
      BoardTags read = agreeing(read_tags(small, quads, reader), tags, board);
      add_overlooked(small, tags, board, reader, read);
      best = {smoothed(read.found, tags, board), factor, border};
    }
    // As with chessboards: tags far away may be too small.
    if (best.tags.size() >= 2 || factor == 1 || factor > 2) return best;
  }
}

}  // namespace

std::optional<DetectedBoard> detect_tags(const cv::Mat& image, const Board& board) {
  const std::vector<BoardTag> tags = board_tags(board);
  const Search search = search_image(image, board, tags);
  const auto expected = board.kind == BoardKind::charuco
                            ? expected_squares(search.tags, tags, board)
                            : expected_tag_corners(search.tags, board, search.border_cells);
  DetectedBoard found = refined(image, search.factor, expected);
  if (found.corners.size() < fewest_corners || !spread_out(found.corners, board.points(), board.square_m))
    return std::nullopt;
  return found;
}

}  // namespace rastro
