// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/orb_spread.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace rastro {
namespace {

constexpr double corners_per_cell = 10.0;
constexpr int least_cell = 8;

/// Smaller for the better corner: by score, then row, then column.
std::uint64_t better_first(const FastCorner& corner) {
  return std::uint64_t{255U - corner.score} << 32U | std::uint64_t{static_cast<std::uint16_t>(corner.y)} << 16U |
         static_cast<std::uint16_t>(corner.x);
}

bool better(const FastCorner& a, const FastCorner& b) { return better_first(a) < better_first(b); }

bool before(const FastCorner& a, const FastCorner& b) { return a.y != b.y ? a.y < b.y : a.x < b.x; }

/// An area divided into square cells.
struct Grid {
  int left, top, cell, columns, rows;

  Grid(int x0, int x1, int y0, int y1, int wanted) : left(x0), top(y0) {
    const double area = static_cast<double>(x1 - x0) * (y1 - y0);
    cell = std::max(least_cell, static_cast<int>(std::sqrt(area * corners_per_cell / std::max(1, wanted))));
    columns = (x1 - x0 + cell - 1) / cell;
    rows = (y1 - y0 + cell - 1) / cell;
  }
  std::size_t cells() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }

  /// The cell of each corner.
  std::vector<std::uint32_t> cells_of(const std::vector<FastCorner>& corners) const {
    std::vector<std::uint32_t> column_of(static_cast<std::size_t>(columns * cell)), result(corners.size());
    for (std::size_t x = 0; x < column_of.size(); ++x)
      column_of[x] = static_cast<std::uint32_t>(x) / static_cast<std::uint32_t>(cell);
    int row = top, first = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (corners[i].y != row) {
        row = corners[i].y;
        first = (row - top) / cell * columns;
      }
      result[i] = static_cast<std::uint32_t>(first) + column_of[static_cast<std::size_t>(corners[i].x - left)];
    }
    return result;
  }
};

/// Indices of `corners` (row by row) in order of quality; a counting sort, because it runs on every detected corner.
std::vector<std::uint32_t> best_first(const std::vector<FastCorner>& corners) {
  std::array<std::uint32_t, 257> next{};
  for (const FastCorner& corner : corners) ++next[256U - corner.score];
  for (std::size_t score = 1; score < next.size(); ++score) next[score] += next[score - 1];
  std::vector<std::uint32_t> order(corners.size());
  for (std::uint32_t i = 0; i < corners.size(); ++i) order[next[255U - corners[i].score]++] = i;
  return order;
}

}  // namespace

OrbCells::OrbCells(const std::vector<FastCorner>& corners, int x0, int x1, int y0, int y1, int wanted, int threshold) {
  const Grid grid(x0, x1, y0, y1, wanted);
  const std::vector<std::uint32_t> cells = grid.cells_of(corners);
  std::vector<std::uint8_t> strong(grid.cells());
  for (std::size_t i = 0; i < corners.size(); ++i) strong[cells[i]] |= corners[i].score > threshold ? 1 : 0;
  const auto stays = [&](std::size_t i) { return corners[i].score > threshold || strong[cells[i]] == 0; };
  first_.assign(grid.cells() + 1, 0);
  for (std::size_t i = 0; i < corners.size(); ++i) first_[cells[i] + 1] += stays(i) ? 1 : 0;
  for (std::size_t cell = 0; cell < grid.cells(); ++cell) first_[cell + 1] += first_[cell];
  corners_.resize(first_.back());
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (const std::uint32_t i : best_first(corners)) {
    if (stays(i)) corners_[next[cells[i]]++] = corners[i];
  }
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
