// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/correlative_search.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace rastro {
namespace {

/// The radius that contains nine in ten points.
double usual_range(std::span<const Eigen::Vector2d> points) {
  std::vector<double> ranges;
  for (const Eigen::Vector2d& point : points) ranges.push_back(point.norm());
  const auto at = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() * 9 / 10);
  std::nth_element(ranges.begin(), at, ranges.end());
  return *at;
}

}  // namespace

struct CorrelativeMap::Candidate {
  int x = 0, y = 0;  ///< Offset in cells.
  /// Sum of the map at all points, in 1/255: at this position, or a bound for the square that starts at it.
  int sum = 0;
};

/// One search: the points rotated by each angle, as cells.
class CorrelativeMap::Search {
 public:
  Search(const CorrelativeMap& map, std::span<const Eigen::Vector2d> points, const SE2& guess,
         const CorrelativeWindow& window)
      : map_(map), points_(points), guess_(guess), window_(window) {
    step_rad_ = map.cell_m_ / std::max(map.cell_m_, usual_range(points));
    rotation_steps_ = static_cast<int>(std::ceil(window.reach_rad / step_rad_));
    reach_ = static_cast<int>(std::ceil(window.reach_m / map.cell_m_));
    best_sum_ = static_cast<int>(std::ceil(255.0 * window.least_score * static_cast<double>(points.size()))) - 1;
  }

  std::optional<CorrelativeFit> run() {
    // From the middle outwards: the likely rotations first give a bound that prunes the others.
    for (int k = 0; k <= 2 * rotation_steps_; ++k) {
      const int rotation_step = k % 2 == 0 ? -k / 2 : (k + 1) / 2;
      search_along(rotation_step);
    }
    if (!found_) return std::nullopt;
    const SE2 pose(guess_.rotation() * SO2::from_angle(best_rotation_ * step_rad_),
                   guess_.translation() + map_.cell_m_ * Eigen::Vector2d(best_.x, best_.y));
    return CorrelativeFit{pose, best_.sum / (255.0 * static_cast<double>(points_.size()))};
  }

 private:
  void search_along(int rotation_step) {
    cells_.clear();
    const SE2 pose(guess_.rotation() * SO2::from_angle(rotation_step * step_rad_), guess_.translation());
    for (const Eigen::Vector2d& point : points_) {
      const Eigen::Vector2d cell = (pose * point - map_.origin_) / map_.cell_m_;
      cells_.emplace_back(static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y())));
    }
    rotation_step_ = rotation_step;
    const int top = static_cast<int>(map_.levels_.size()) - 1, side = 1 << top;
    std::vector<Candidate> candidates;
    for (int y = -reach_; y <= reach_; y += side) {
      for (int x = -reach_; x <= reach_; x += side) candidates.push_back({x, y, sum_at(top, x, y)});
    }
    descend(candidates, top);
  }

  void descend(std::vector<Candidate>& candidates, int level) {
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.sum > b.sum; });
    for (const Candidate& candidate : candidates) {
      if (candidate.sum <= best_sum_) return;
      if (level == 0) {
        best_ = candidate;
        best_sum_ = candidate.sum;
        best_rotation_ = rotation_step_;
        found_ = true;
        return;
      }
      const int half = 1 << (level - 1);
      std::vector<Candidate> finer;
      for (const int y : {candidate.y, candidate.y + half}) {
        for (const int x : {candidate.x, candidate.x + half}) {
          if (x <= reach_ && y <= reach_) finer.push_back({x, y, sum_at(level - 1, x, y)});
        }
      }
      descend(finer, level - 1);
    }
  }

  int sum_at(int level, int x, int y) const {
    const Level& map = map_.levels_[static_cast<std::size_t>(level)];
    const int shift = map.size - 1;
    int sum = 0;
    for (const Eigen::Vector2i& cell : cells_) {
      const int column = cell.x() + x + shift, row = cell.y() + y + shift;
      if (static_cast<unsigned>(column) >= static_cast<unsigned>(map.width) ||
          static_cast<unsigned>(row) >= static_cast<unsigned>(map.height))
        continue;
      sum += map.cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(map.width) +
                       static_cast<std::size_t>(column)];
    }
    return sum;
  }

  const CorrelativeMap& map_;
  std::span<const Eigen::Vector2d> points_;
  SE2 guess_;
  CorrelativeWindow window_;
  double step_rad_ = 0.0;
  int rotation_steps_ = 0, reach_ = 0, rotation_step_ = 0;
  std::vector<Eigen::Vector2i> cells_;
  Candidate best_;
  int best_sum_ = 0, best_rotation_ = 0;
  bool found_ = false;
};

CorrelativeMap::CorrelativeMap(const ProbabilityView& map, int levels) : cell_m_(map.cell_m), origin_(map.origin) {
  Level finest{1, map.width, map.height, {}};
  const auto cells = static_cast<std::ptrdiff_t>(map.width) * map.height;
  finest.cells.assign(map.cells, map.cells + cells);
  // Cells not known to be occupied count nothing, or a scan would fit best in unknown space.
  constexpr std::uint8_t nothing_known = 128;
  for (std::uint8_t& cell : finest.cells) {
    if (cell <= nothing_known) cell = 0;
  }
  levels_.push_back(std::move(finest));
  for (int level = 1; level < levels; ++level) levels_.push_back(widened(levels_.back()));
}

/// Maximum over twice the square: in x, then in y.
CorrelativeMap::Level CorrelativeMap::widened(const Level& fine) {
  const int grown = fine.size;
  Level wide{2 * fine.size, fine.width + grown, fine.height + grown, {}};
  std::vector<std::uint8_t> rows(static_cast<std::size_t>(wide.width) * static_cast<std::size_t>(fine.height), 0);
  for (int y = 0; y < fine.height; ++y) {
    const std::uint8_t* in = fine.cells.data() + static_cast<std::ptrdiff_t>(y) * fine.width;
    std::uint8_t* out = rows.data() + static_cast<std::ptrdiff_t>(y) * wide.width;
    std::copy_n(in, fine.width, out + grown);
    for (int x = 0; x < fine.width; ++x) out[x] = std::max(out[x], in[x]);
  }
  wide.cells.assign(static_cast<std::size_t>(wide.width) * static_cast<std::size_t>(wide.height), 0);
  for (int y = 0; y < fine.height; ++y) {
    const std::uint8_t* in = rows.data() + static_cast<std::ptrdiff_t>(y) * wide.width;
    for (const int to : {y, y + grown}) {
      std::uint8_t* out = wide.cells.data() + static_cast<std::ptrdiff_t>(to) * wide.width;
      for (int x = 0; x < wide.width; ++x) out[x] = std::max(out[x], in[x]);
    }
  }
  return wide;
}

std::optional<CorrelativeFit> CorrelativeMap::search(std::span<const Eigen::Vector2d> points, const SE2& guess,
                                                     const CorrelativeWindow& window) const {
  if (points.empty()) return std::nullopt;
  return Search(*this, points, guess, window).run();
}

}  // namespace rastro
