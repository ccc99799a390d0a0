// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/orb_spread.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>

namespace rastro {
namespace {

constexpr double corners_per_cell = 10.0;
constexpr int least_cell = 8;

bool better(const FastCorner& a, const FastCorner& b) {
  return std::make_tuple(-a.score, a.y, a.x) < std::make_tuple(-b.score, b.y, b.x);
}

bool before(const FastCorner& a, const FastCorner& b) { return std::make_pair(a.y, a.x) < std::make_pair(b.y, b.x); }

/// An area in square cells.
struct Grid {
  int left, top, cell, columns, rows;

  Grid(int x0, int x1, int y0, int y1, int wanted) : left(x0), top(y0) {
    const double area = static_cast<double>(x1 - x0) * (y1 - y0);
    cell = std::max(least_cell, static_cast<int>(std::sqrt(area * corners_per_cell / std::max(1, wanted))));
    columns = (x1 - x0 + cell - 1) / cell;
    rows = (y1 - y0 + cell - 1) / cell;
  }
  std::size_t cells() const { return static_cast<std::size_t>(columns * rows); }
  std::size_t cell_of(const FastCorner& corner) const {
    return static_cast<std::size_t>((corner.y - top) / cell * columns + (corner.x - left) / cell);
  }
};

}  // namespace

OrbCells::OrbCells(const std::vector<FastCorner>& corners, int x0, int x1, int y0, int y1, int wanted, int threshold) {
  const Grid grid(x0, x1, y0, y1, wanted);
  std::vector<std::uint8_t> strong(grid.cells());
  for (const FastCorner& corner : corners) strong[grid.cell_of(corner)] |= corner.score > threshold ? 1 : 0;
  first_.assign(grid.cells() + 1, 0);
  for (const FastCorner& corner : corners) {
    const std::size_t cell = grid.cell_of(corner);
    if (corner.score > threshold || strong[cell] == 0) ++first_[cell + 1];
  }
  for (std::size_t cell = 0; cell < grid.cells(); ++cell) first_[cell + 1] += first_[cell];
  corners_.resize(first_.back());
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (const FastCorner& corner : corners) {
    const std::size_t cell = grid.cell_of(corner);
    if (corner.score > threshold || strong[cell] == 0) corners_[next[cell]++] = corner;
  }
  for (std::size_t cell = 0; cell < grid.cells(); ++cell)
    std::sort(corners_.begin() + static_cast<std::ptrdiff_t>(first_[cell]),
              corners_.begin() + static_cast<std::ptrdiff_t>(first_[cell + 1]), better);
}

std::vector<FastCorner> OrbCells::take(std::size_t quota) const {
  std::vector<FastCorner> taken, round;
  for (std::size_t rank = 0; taken.size() < quota; ++rank) {
    round.clear();
    for (std::size_t cell = 0; cell + 1 < first_.size(); ++cell)
      if (first_[cell] + rank < first_[cell + 1]) round.push_back(corners_[first_[cell] + rank]);
    if (round.empty()) break;
    if (taken.size() + round.size() > quota) {
      std::sort(round.begin(), round.end(), better);
      round.resize(quota - taken.size());
    }
    taken.insert(taken.end(), round.begin(), round.end());
  }
  std::sort(taken.begin(), taken.end(), before);
  return taken;
}

std::vector<std::size_t> orb_quotas(std::size_t features, double scale_factor,
                                    const std::vector<std::size_t>& available) {
  const std::size_t levels = available.size();
  double sum = 0.0;
  for (std::size_t level = 0; level < levels; ++level) sum += std::pow(scale_factor, -static_cast<double>(level));
  std::vector<std::size_t> quotas(levels);
  std::size_t left = features;
  double rest = 0.0;
  for (std::size_t level = levels; level-- > 0;) {
    rest += static_cast<double>(features) * std::pow(scale_factor, -static_cast<double>(level)) / sum;
    const auto fair = static_cast<std::size_t>(std::lround(std::max(0.0, rest)));
    quotas[level] = std::min({fair, available[level], left});
    rest -= static_cast<double>(quotas[level]);
    left -= quotas[level];
  }
  for (std::size_t level = 0; level < levels; ++level) {
    const std::size_t more = std::min(left, available[level] - quotas[level]);
    quotas[level] += more;
    left -= more;
  }
  return quotas;
}

}  // namespace rastro
