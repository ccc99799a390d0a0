// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/depth_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "rastro/input_check/motion_residual.h"
#include "rastro/input_check/sample_schedule.h"

namespace rastro {
namespace {

constexpr int cell_px = 4;
constexpr double edge_share = 0.12;        // Of the cells: those with the largest gradients are edges.
constexpr double least_depth_step = 0.08;  // Of the depth.
constexpr std::size_t least_steps = 60;
constexpr int least_advantages = 10;
constexpr double least_better = 0.75;
constexpr double least_mirror_gain = 0.12, least_gain_ratio = 1.5;
// By the motion of features, as in FocalCheck.
constexpr double clear_residuals = 0.8, least_mirror_evidence = 0.7;
constexpr double constant_spread = 0.002;
constexpr std::size_t least_depths = 500;
constexpr int least_constant = 5;
constexpr int least_empty = 60;
constexpr double empty_share = 0.005;  // Of the pixels: fewer with depth are none.

Image<std::uint8_t> in_cells(const GrayImage& image) {
  Image<std::uint8_t> cells(image.width() / cell_px, image.height() / cell_px);
  for (int y = 0; y < cells.height(); ++y) {
    for (int x = 0; x < cells.width(); ++x) {
      int sum = 0;
      for (int row = 0; row < cell_px; ++row)
        for (int column = 0; column < cell_px; ++column) sum += image.at(cell_px * x + column, cell_px * y + row);
      cells.at(x, y) = static_cast<std::uint8_t>(sum / (cell_px * cell_px));
    }
  }
  return cells;
}

/// Marks the cells of the largest gradients, and those beside them to the left and right.
Image<std::uint8_t> edges_of(const GrayImage& image) {
  const Image<std::uint8_t> cells = in_cells(image);
  Image<std::uint8_t> edges(cells.width(), cells.height());
  if (cells.width() < 3 || cells.height() < 3) return edges;
  const auto gradient = [&](int x, int y) {
    return std::abs(cells.at(x + 1, y) - cells.at(x - 1, y)) + std::abs(cells.at(x, y + 1) - cells.at(x, y - 1));
  };
  std::vector<int> all;
  for (int y = 1; y + 1 < cells.height(); ++y)
    for (int x = 1; x + 1 < cells.width(); ++x) all.push_back(gradient(x, y));
  const auto bound = all.begin() + static_cast<std::ptrdiff_t>((1.0 - edge_share) * static_cast<double>(all.size()));
  std::nth_element(all.begin(), bound, all.end());
  const int least = std::max(4, *bound);
  for (int y = 1; y + 1 < cells.height(); ++y)
    for (int x = 1; x + 1 < cells.width(); ++x)
      if (gradient(x, y) >= least) edges.at(x - 1, y) = edges.at(x, y) = edges.at(x + 1, y) = 1;
  return edges;
}

std::vector<Eigen::Vector2i> steps_of(const DepthImage& depth) {
  std::vector<Eigen::Vector2i> steps;
  const int width = depth.width() / cell_px, height = depth.height() / cell_px;
  const auto at = [&](int x, int y) { return static_cast<double>(depth.at(cell_px * x + 1, cell_px * y + 1)); };
  // Sideways over two cells, since there is often no depth beside a nearer surface.
  for (int y = 1; y + 1 < height; ++y) {
    for (int x = 2; x + 2 < width; ++x) {
      const double before = at(x - 2, y), behind = at(x + 2, y);
      if (!(before > 0.0) || !(behind > 0.0)) continue;
      if (std::abs(behind - before) > 2.0 * least_depth_step * std::min(before, behind)) steps.emplace_back(x, y);
    }
  }
  return steps;
}

/// Share of the steps on edges, above that of all cells.
double share_on_edges(const std::vector<Eigen::Vector2i>& steps, const Image<std::uint8_t>& edges, bool mirrored) {
  int hits = 0;
  for (const Eigen::Vector2i& step : steps)
    hits += edges.at(mirrored ? edges.width() - 1 - step.x() : step.x(), step.y());
  return static_cast<double>(hits) / static_cast<double>(steps.size());
}

}  // namespace

void DepthCheck::Advantage::add(double own_share, double other_share) {
  ++frames;
  better += other_share > own_share ? 1 : 0;
  sum += other_share - own_share;
  own += own_share;
  other += other_share;
}

bool DepthCheck::Advantage::is_sure(double least_mean) const {
  return frames >= least_advantages && sum >= least_mean * frames && better >= least_better * frames &&
         other >= least_gain_ratio * own;
}

void DepthCheck::add(const Frame& frame, InputWarnings& found) {
  if (frame.depth.empty() || frame.image.empty() || frame.depth.width() != frame.image.width() ||
      frame.depth.height() != frame.image.height())
    return;
  const std::int64_t number = frames_++;
  if (!is_in_burst(number)) return;
  check_presence(frame.depth, found);
  check_spread(frame.depth, found);
  if (is_wrong()) return;
  check_steps(frame, found);
}

void DepthCheck::add(const TrackedWindow& window, const Camera& camera, InputWarnings& found) {
  if (is_wrong()) return;
  const auto residuals = mirror_residuals(window, camera);
  if (!residuals) return;
  const double given = residuals->given_px, mirrored = residuals->mirrored_px;
  if (given < clear_residuals * mirrored) ++windows_right_;
  if (mirrored > clear_residuals * given) return;
  ++windows_mirrored_;
  mirror_evidence_ += std::log(given / mirrored);
  if (windows_mirrored_ < 2 || windows_mirrored_ < 3 * windows_right_ || mirror_evidence_ < least_mirror_evidence)
    return;
  said_ = true;
  found.push_back({"depth_mirrored",
                   fmt::format("the depth seems to be mirrored: features move as their depth says to {:.2f} px, and to "
                               "{:.2f} px with the depth mirrored left to right ({} windows)",
                               given, mirrored, windows_mirrored_)});
}

void DepthCheck::check_presence(const DepthImage& depth, InputWarnings& found) {
  if (said_empty_) return;
  std::int64_t measured = 0;
  for (int y = 0; y < depth.height(); ++y)
    measured += std::count_if(depth.row(y), depth.row(y) + depth.width(), [](float meters) { return meters > 0.0F; });
  const double share = static_cast<double>(measured) / (static_cast<double>(depth.width()) * depth.height());
  (share < empty_share ? empty_ : filled_) += 1;
  if (empty_ < least_empty || empty_ < 10 * filled_) return;
  said_empty_ = true;
  found.push_back(
      {"depth_empty",
       fmt::format("{} of {} depth images are empty: fewer than {:g} % of their pixels have a depth; is the "
                   "sensor covered, the scene too near or too far, or the depth factor wrong?",
                   empty_, empty_ + filled_, 100.0 * empty_share)});
}

void DepthCheck::check_spread(const DepthImage& depth, InputWarnings& found) {
  constexpr int step_px = 8;
  std::vector<float> depths;
  for (int y = 0; y < depth.height(); y += step_px)
    for (int x = 0; x < depth.width(); x += step_px)
      if (depth.at(x, y) > 0.0F) depths.push_back(depth.at(x, y));
  if (depths.size() < least_depths) return;
  std::sort(depths.begin(), depths.end());
  const double low = static_cast<double>(depths[depths.size() / 20]),
               high = static_cast<double>(depths[depths.size() - 1 - depths.size() / 20]);
  (high - low < constant_spread * low ? constant_ : varied_) += 1;
  if (said_constant_ || constant_ < least_constant || constant_ < 10 * varied_) return;
  said_constant_ = true;
  found.push_back({"depth_constant",
                   fmt::format("the depth is the same everywhere: 90 % of the pixels of {} images are within {:.1f} mm "
                               "of {:.3f} m; is it depth of this camera?",
                               constant_, 500.0 * (high - low), 0.5 * (low + high))});
}

void DepthCheck::check_steps(const Frame& frame, InputWarnings& found) {
  const Image<std::uint8_t> is_edge = edges_of(frame.image);
  const std::vector<Eigen::Vector2i> steps = steps_of(frame.depth);
  if (steps.size() < least_steps) return;
  mirrored_.add(share_on_edges(steps, is_edge, false), share_on_edges(steps, is_edge, true));
  if (!mirrored_.is_sure(least_mirror_gain)) return;
  said_ = true;
  found.push_back({"depth_mirrored",
                   fmt::format("the depth seems to be mirrored: {:.0f} % of its steps lie on edges of the image as it "
                               "is, {:.0f} % of them mirrored left to right ({} images)",
                               100.0 * mirrored_.own / mirrored_.frames, 100.0 * mirrored_.other / mirrored_.frames,
                               mirrored_.frames)});
}

}  // namespace rastro
