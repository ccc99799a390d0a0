// SPDX-License-Identifier: Apache-2.0
// Boards with tags: ChArUco boards and grids of AprilTags.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>

#include "rastro/calibration/board_dictionary.h"
#include "rastro/calibration/board_image.h"

namespace rastro {
namespace {

constexpr int search_size = 1000;
constexpr std::size_t fewest_corners = 6;
/// Of the side of a tag: where its neighbors may be off from where it says, by perspective that its own corners tell
/// badly and by the lens. A tag that was misread is off by a whole side or more.
constexpr double neighbor_tolerance = 0.4;

/// Between black and white of a tag, gray levels.
constexpr float least_contrast = 20.0F;

using Quad = std::array<cv::Point2f, 4>;

/// Tags by their number on the board, corners clockwise from the upper left.
using FoundTags = std::map<int, Quad>;

/// Tags of a ChArUco board.
FoundTags search_tags(const cv::Mat& image, const Board& board, int tag_count) {
  const auto parameters = cv::aruco::DetectorParameters::create();
  // Tags of a large grid are small: 12 pixels a side in an image of 1000.
  parameters->minMarkerPerimeterRate = 0.045;
  parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_NONE;
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(image, cv::aruco::getPredefinedDictionary(dictionary_number(board.tags).value_or(0)),
                           corners, ids, parameters);
  FoundTags found;
  std::map<int, int> seen;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] >= tag_count || corners[i].size() != 4) continue;
    ++seen[ids[i]];
    std::copy_n(corners[i].begin(), 4, found[ids[i]].begin());
  }
  std::erase_if(found, [&](const auto& tag) { return seen[tag.first] > 1; });
  return found;
}

/// From the board's plane to the image, as the corners of one tag say.
cv::Matx33d image_from_board(const BoardTag& tag, double side, const Quad& corners) {
  const auto left = static_cast<float>(tag.upper_left.x()), top = static_cast<float>(tag.upper_left.y());
  const auto s = static_cast<float>(side);
  const Quad flat = {cv::Point2f(left, top), {left + s, top}, {left + s, top + s}, {left, top + s}};
  const cv::Mat homography = cv::getPerspectiveTransform(flat.data(), corners.data());
  return cv::Matx33d(homography.ptr<double>());
}

cv::Point2f mapped(const cv::Matx33d& homography, const Eigen::Vector2d& point) {
  const cv::Vec3d image = homography * cv::Vec3d(point.x(), point.y(), 1.0);
  if (!(std::abs(image[2]) > 1e-12)) return {-1e6F, -1e6F};
  return {static_cast<float>(image[0] / image[2]), static_cast<float>(image[1] / image[2])};
}

float shortest_side(const Quad& quad) {
  double shortest = 1e9;
  for (std::size_t k = 0; k < 4; ++k) shortest = std::min(shortest, cv::norm(quad[k] - quad[(k + 1) % 4]));
  return static_cast<float>(shortest);
}

cv::Point2f center_of(const Quad& quad) { return (quad[0] + quad[1] + quad[2] + quad[3]) * 0.25F; }

Quad turned(const Quad& quad, std::size_t turns) {
  return {quad[turns % 4], quad[(1 + turns) % 4], quad[(2 + turns) % 4], quad[(3 + turns) % 4]};
}

/// Corners farther out by `pixels` along both sides.
Quad grown(const Quad& quad, float pixels) {
  const cv::Point2f center = center_of(quad);
  Quad result;
  for (std::size_t k = 0; k < 4; ++k) {
    const cv::Point2f out = quad[k] - center;
    result[k] = quad[k] + out * (1.41421356F * pixels / std::max(1.0F, static_cast<float>(cv::norm(out))));
  }
  return result;
}

/// Gray of the cells of a tag, row by row.
std::vector<float> cell_values(const cv::Mat& image, const Quad& quad, int cells) {
  const auto end = static_cast<float>(cells);
  const Quad flat = {cv::Point2f(0.0F, 0.0F), {end, 0.0F}, {end, end}, {0.0F, end}};
  const cv::Matx33d homography(cv::Mat(cv::getPerspectiveTransform(flat.data(), quad.data())).ptr<double>());
  std::vector<float> values;
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) {
      float sum = 0.0F;
      for (int k = 0; k < 5; ++k) {
        const double u = x + 0.5 +
                         (k == 1   ? 0.2
                          : k == 2 ? -0.2
                                   : 0.0),
                     v = y + 0.5 +
                         (k == 3   ? 0.2
                          : k == 4 ? -0.2
                                   : 0.0);
        const cv::Point2f at = mapped(homography, {u, v});
        const int left = std::clamp(static_cast<int>(std::lround(at.x)), 0, image.cols - 1);
        const int top = std::clamp(static_cast<int>(std::lround(at.y)), 0, image.rows - 1);
        sum += static_cast<float>(image.at<std::uint8_t>(top, left));
      }
      values.push_back(sum / 5.0F);
    }
  return values;
}

struct ReadTag {
  int id = 0;
  Quad corners;
};

/// The tag in a quad whose border is dark; nullopt for what is none.
std::optional<ReadTag> read_tag(const cv::Mat& image, const Quad& quad, cv::aruco::Dictionary& dictionary,
                                int border_cells) {
  const int cells = dictionary.markerSize + 2 * border_cells;
  const std::vector<float> values = cell_values(image, quad, cells);
  std::vector<float> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t tenth = sorted.size() / 10;
  const float dark = sorted[tenth], bright = sorted[sorted.size() - 1 - tenth];
  if (bright - dark < least_contrast) return std::nullopt;
  cv::Mat bits(dictionary.markerSize, dictionary.markerSize, CV_8UC1);
  int wrong = 0;
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) {
      const bool white = values[static_cast<std::size_t>(y * cells + x)] > 0.5F * (dark + bright);
      const int column = x - border_cells, row = y - border_cells;
      if (column < 0 || row < 0 || column >= bits.cols || row >= bits.rows) {
        wrong += white ? 1 : 0;
      } else {
        bits.at<std::uint8_t>(row, column) = white ? 1 : 0;
      }
    }
  int id = 0, rotation = 0;
  if (wrong > cells / 3 || !dictionary.identify(bits, id, rotation, 0.6)) return std::nullopt;
  return ReadTag{id, turned(quad, static_cast<std::size_t>(4 - rotation))};
}

/// Dark quads, corners clockwise. The squares between the tags of a grid touch their corners, so that all may be one
/// dark shape: it is made thinner by `radius` pixels, and each quad larger again.
std::vector<Quad> dark_quads(const cv::Mat& dark, int radius) {
  cv::Mat thinner;
  cv::erode(dark, thinner, cv::getStructuringElement(cv::MORPH_RECT, {2 * radius + 1, 2 * radius + 1}));
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(thinner, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
  std::vector<Quad> quads;
  for (const auto& contour : contours) {
    if (contour.size() < 50) continue;
    std::vector<cv::Point> polygon;
    cv::approxPolyDP(contour, polygon, 0.05 * static_cast<double>(contour.size()), true);
    if (polygon.size() != 4 || !cv::isContourConvex(polygon)) continue;
    Quad quad;
    std::copy(polygon.begin(), polygon.end(), quad.begin());
    const cv::Point2f along = quad[1] - quad[0], across = quad[2] - quad[0];
    if (along.x * across.y - along.y * across.x < 0.0F) std::swap(quad[1], quad[3]);
    quads.push_back(grown(quad, static_cast<float>(radius)));
  }
  return quads;
}

/// Tags of a grid, whose quads OpenCV's search would not tell apart.
FoundTags search_grid(const cv::Mat& image, const Board& board, int tag_count, int border_cells) {
  const auto dictionary = cv::aruco::getPredefinedDictionary(dictionary_number(board.tags).value_or(0));
  const int largest = std::max(image.cols, image.rows);
  const int scale = largest <= 1000 ? 2 : 1;
  cv::Mat large, dark;
  cv::resize(image, large, {}, scale, scale, cv::INTER_LINEAR);
  const int block = (scale * largest / 10) | 1;
  cv::adaptiveThreshold(large, dark, 255, cv::ADAPTIVE_THRESH_MEAN_C, cv::THRESH_BINARY_INV, block, 5.0);
  FoundTags found;
  for (const int radius : {1, 2})
    for (const Quad& quad : dark_quads(dark, radius)) {
      Quad corners;
      for (std::size_t k = 0; k < 4; ++k)
        corners[k] = (quad[k] + cv::Point2f(0.5F, 0.5F)) / static_cast<float>(scale) - cv::Point2f(0.5F, 0.5F);
      const auto tag = read_tag(image, corners, *dictionary, border_cells);
      if (tag && tag->id < tag_count) found.try_emplace(tag->id, tag->corners);
    }
  return found;
}

/// Whether one of the nearest other tags is where this one says.
bool agrees(int number, const FoundTags& found, const std::vector<BoardTag>& tags, const Board& board) {
  const auto at = [&](int n) -> const BoardTag& { return tags[static_cast<std::size_t>(n)]; };
  const Quad& quad = found.at(number);
  const cv::Matx33d homography = image_from_board(at(number), board.tag_m, quad);
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(0.5 * board.tag_m);
  for (const auto& [other, corners] : found) {
    if (other == number || (at(other).upper_left - at(number).upper_left).norm() > 2.1 * board.square_m) continue;
    const cv::Point2f said = mapped(homography, at(other).upper_left + half);
    if (cv::norm(said - center_of(corners)) <
        neighbor_tolerance * std::max(shortest_side(quad), shortest_side(corners)))
      return true;
  }
  return false;
}

/// Without tags that were misread, and with the first corner where the board has it: printed grids have their tags
/// turned by any multiple of 90 degrees, all alike.
FoundTags agreeing(const FoundTags& found, const std::vector<BoardTag>& tags, const Board& board) {
  FoundTags best;
  const std::size_t most_turns = board.kind == BoardKind::apriltag ? 4 : 1;
  for (std::size_t turns = 0; turns < most_turns; ++turns) {
    FoundTags all, good;
    for (const auto& [number, quad] : found) all[number] = turned(quad, turns);
    for (const auto& [number, quad] : all)
      if (agrees(number, all, tags, board)) good[number] = quad;
    if (good.size() > best.size()) best = std::move(good);
  }
  return best;
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
      sum += mapped(image_from_board(tag, board.tag_m, quad), points[corner]);
      side = std::min(side, shortest_side(quad));
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
      expected[4 * number + k] = {quad[static_cast<std::size_t>(k)], shortest_side(quad) * share};
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
    if (!inside(at.front()) || at.front() == before) continue;  // It stays where it was when it does not converge.
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
  for (int factor = std::max(1, (largest + search_size / 2) / search_size);; factor = (factor + 1) / 2) {
    const cv::Mat small = reduced_image(full, factor);
    for (int border = 1; border <= most_border && best.tags.size() < 2; ++border) {
      const auto count = static_cast<int>(tags.size());
      const FoundTags found = board.kind == BoardKind::apriltag ? search_grid(small, board, count, border)
                                                                : search_tags(small, board, count);
      best = {agreeing(found, tags, board), factor, border};
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
