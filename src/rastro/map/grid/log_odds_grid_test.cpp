// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/grid/log_odds_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "rastro/base/random.h"

namespace rastro {
namespace {

using Cell = std::pair<int, int>;

constexpr double cell_m = 0.25;  // A power of two, so that positions and cells are exact.
constexpr std::uint8_t nothing_known = 128;
/// Its values times 255 are far from halves, so that the steps of log-odds do not affect rounding.
const LogOddsModel usual_model{0.85, 0.4, 6.0};

/// Cells counted from the grid's own origin, wherever its corner is.
Eigen::Vector2i corner_of(const ProbabilityView& view) {
  return (view.origin / view.cell_m).array().round().cast<int>();
}

int value_at(const ProbabilityView& view, const Cell& cell) {
  const Eigen::Vector2i corner = corner_of(view);
  const int x = cell.first - corner.x(), y = cell.second - corner.y();
  if (x < 0 || y < 0 || x >= view.width || y >= view.height) return nothing_known;
  return view.cells[static_cast<std::ptrdiff_t>(y) * view.width + x];
}

std::map<Cell, int> known_cells(const ProbabilityView& view) {
  std::map<Cell, int> known;
  const Eigen::Vector2i corner = corner_of(view);
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      const int value = view.cells[static_cast<std::ptrdiff_t>(y) * view.width + x];
      if (value != nothing_known) known[{x + corner.x(), y + corner.y()}] = value;
    }
  }
  return known;
}

Eigen::Vector2d middle_of(const Cell& cell) { return cell_m * Eigen::Vector2d(cell.first + 0.5, cell.second + 0.5); }

/// The model's value of a cell after these hits and passes, without the limit.
int modeled(const LogOddsModel& model, int hits, int passes) {
  const double sum = hits * std::log(model.occupied_probability / (1.0 - model.occupied_probability)) +
                     passes * std::log(model.free_probability / (1.0 - model.free_probability));
  const double held = std::clamp(sum, -model.largest_log_odds, model.largest_log_odds);
  return static_cast<int>(std::lround(255.0 / (1.0 + std::exp(-held))));
}

int along_of(const Cell& cell, bool steep) { return steep ? cell.second : cell.first; }
int across_of(const Cell& cell, bool steep) { return steep ? cell.first : cell.second; }

/// The beam crosses one cell for each step along its longer axis, and each lies within half a cell of the exact line.
void expect_line(const std::set<Cell>& cells, const Cell& from, const Cell& to) {
  const int dx = to.first - from.first, dy = to.second - from.second;
  const bool steep = std::abs(dy) > std::abs(dx);
  const int length = std::max(std::abs(dx), std::abs(dy)), sign = (steep ? dy : dx) < 0 ? -1 : 1;
  ASSERT_EQ(static_cast<int>(cells.size()), length);
  std::set<int> steps;
  for (const Cell& cell : cells) {
    const int step = sign * (along_of(cell, steep) - along_of(from, steep));
    EXPECT_GE(step, 0);
    EXPECT_LT(step, length) << "the last cell is the return's";
    steps.insert(step);
    const double exact = across_of(from, steep) + static_cast<double>(step) * (steep ? dx : dy) / length;
    EXPECT_LE(std::abs(across_of(cell, steep) - exact), 0.5 + 1e-9) << cell.first << ' ' << cell.second;
  }
  EXPECT_EQ(static_cast<int>(steps.size()), length);
}

TEST(LogOddsGrid, OneBeamIsTheLineBetweenItsEnds) {
  Random random(3);
  for (int round = 0; round < 300; ++round) {
    const Cell from{static_cast<int>(random.below(41)) - 20, static_cast<int>(random.below(41)) - 20};
    Cell to{static_cast<int>(random.below(41)) - 20, static_cast<int>(random.below(41)) - 20};
    if (round % 5 == 0) to.first = from.first;
    if (round % 7 == 0) to.second = from.second;
    if (round % 11 == 0) to.second = from.second + to.first - from.first;
    const LogOddsModel& model = usual_model;
    LogOddsGrid grid(cell_m, model);
    const std::vector<Eigen::Vector2d> returns{middle_of(to)};
    grid.insert(middle_of(from), returns);
    std::set<Cell> passed;
    for (const auto& [cell, value] : known_cells(grid.view())) {
      if (cell == to) {
        EXPECT_EQ(value, modeled(model, 1, 0));
      } else {
        EXPECT_EQ(value, modeled(model, 0, 1));
        passed.insert(cell);
      }
    }
    EXPECT_EQ(value_at(grid.view(), to), modeled(model, 1, 0));
    expect_line(passed, from, to);
  }
}

TEST(LogOddsGrid, ScansAddUpByTheModelAndStopAtItsLimit) {
  const LogOddsModel model{0.7, 0.35, 3.0};
  const Cell sensor{0, 0}, passed{3, 0}, hit{6, 0};
  LogOddsGrid grid(cell_m, model);
  const std::vector<Eigen::Vector2d> returns{middle_of(hit)};
  bool limited = false;
  for (int scans = 1; scans <= 12; ++scans) {
    grid.insert(middle_of(sensor), returns);
    // The steps of log-odds are 1/256 each: the rounding of some scans is at most one part of 255.
    EXPECT_NEAR(value_at(grid.view(), hit), modeled(model, scans, 0), 1) << scans;
    EXPECT_NEAR(value_at(grid.view(), passed), modeled(model, 0, scans), 1) << scans;
    limited = modeled(model, scans, 0) == modeled(model, scans + 1, 0);
  }
  EXPECT_TRUE(limited) << "the test must reach the limit";
  const int surest = value_at(grid.view(), hit);
  const std::vector<Eigen::Vector2d> beyond{middle_of({9, 0})};
  grid.insert(middle_of(sensor), beyond);
  EXPECT_LT(value_at(grid.view(), hit), surest) << "can still be convinced";
}

TEST(LogOddsGrid, AReturnOutweighsBeamsOfTheSameScanInAnyOrder) {
  const LogOddsModel& model = usual_model;
  const Cell near{4, 0}, far{8, 0};
  for (const bool near_first : {true, false}) {
    LogOddsGrid grid(cell_m, model);
    std::vector<Eigen::Vector2d> returns{middle_of(near), middle_of(far), middle_of(near), middle_of(far)};
    if (!near_first) std::swap(returns[0], returns[1]);
    for (int scan = 1; scan <= 2; ++scan) {
      grid.insert(middle_of({0, 0}), returns);
      EXPECT_EQ(value_at(grid.view(), near), modeled(model, scan, 0)) << "once a scan, as a return";
      EXPECT_EQ(value_at(grid.view(), far), modeled(model, scan, 0));
      EXPECT_EQ(value_at(grid.view(), {2, 0}), modeled(model, 0, scan)) << "two beams of one scan count as one";
    }
  }
}

TEST(LogOddsGrid, EqualsHitsAndPassesCountedPerScan) {
  // Scans of many beams from many positions: a cell's value follows from its number of scans with a return in it and of
  // scans with only beams through it. Each beam covers the cells of a single beam.
  Random random(11);
  const LogOddsModel model{0.6, 0.45, 6.0};
  LogOddsGrid grid(cell_m, model);
  std::map<Cell, std::pair<int, int>> counts;
  for (int scan = 0; scan < 8; ++scan) {
    const Cell sensor{static_cast<int>(random.below(200)) - 100, static_cast<int>(random.below(200)) - 100};
    std::vector<Eigen::Vector2d> returns;
    std::set<Cell> hit, passed;
    for (int beam = 0; beam < 60; ++beam) {
      const Cell end{sensor.first + static_cast<int>(random.below(61)) - 30,
                     sensor.second + static_cast<int>(random.below(61)) - 30};
      returns.push_back(middle_of(end));
      hit.insert(end);
      LogOddsGrid alone(cell_m, model);
      alone.insert(middle_of(sensor), std::span(&returns.back(), 1));
      for (const auto& [cell, value] : known_cells(alone.view())) {
        if (cell != end) passed.insert(cell);
      }
    }
    grid.insert(middle_of(sensor), returns);
    for (const Cell& cell : hit) ++counts[cell].first;
    for (const Cell& cell : passed) {
      if (!hit.contains(cell)) ++counts[cell].second;
    }
  }
  for (const auto& [cell, count] : counts)
    EXPECT_NEAR(value_at(grid.view(), cell), modeled(model, count.first, count.second), 1);
  for (const auto& [cell, value] : known_cells(grid.view())) EXPECT_TRUE(counts.contains(cell));
}

TEST(LogOddsGrid, GrowthKeepsTheCells) {
  LogOddsGrid grid(cell_m, usual_model);
  const std::vector<Eigen::Vector2d> near{middle_of({5, 3}), middle_of({-6, 2}), middle_of({1, -7})};
  grid.insert(middle_of({0, 0}), near);
  const std::map<Cell, int> before = known_cells(grid.view());
  const ProbabilityView small = grid.view();
  for (const Cell& far : {Cell{400, 10}, {-300, 20}, {15, 500}, {-20, -600}}) {
    // Beyond the first cells, which the far beams do not reach.
    const std::vector<Eigen::Vector2d> returns{middle_of({far.first + 2, far.second})};
    grid.insert(middle_of(far), returns);
    std::map<Cell, int> now = known_cells(grid.view());
    for (const auto& [cell, value] : before) EXPECT_EQ(now[cell], value);
    EXPECT_EQ(now[(Cell{far.first + 2, far.second})], modeled(usual_model, 1, 0));
  }
  EXPECT_EQ(known_cells(grid.view()).size(), before.size() + 4 * 3);
  EXPECT_GT(grid.view().width, small.width);
  // A cell changed before the growth keeps its count of scans.
  grid.insert(middle_of({0, 0}), near);
  EXPECT_EQ(value_at(grid.view(), {5, 3}), modeled(usual_model, 2, 0));
}

TEST(LogOddsGrid, ReturnsTooFarAwayAreLeftOut) {
  LogOddsGrid grid(cell_m, usual_model);
  const std::vector<Eigen::Vector2d> returns{{32768 * cell_m + 1.0, 0.0}, middle_of({2, 0})};
  grid.insert(middle_of({0, 0}), returns);
  EXPECT_EQ(known_cells(grid.view()).size(), 3U);
  EXPECT_LT(grid.view().width, 1000);
}

TEST(LogOddsGrid, AFrozenGridReadsTheSame) {
  LogOddsGrid grid(cell_m, usual_model);
  EXPECT_EQ(grid.view().width, 0);
  const std::vector<Eigen::Vector2d> returns{middle_of({5, 3}), middle_of({-6, 2})};
  grid.insert(middle_of({0, 0}), returns);
  const std::map<Cell, int> before = known_cells(grid.view());
  const Eigen::Vector2d origin = grid.view().origin;
  grid.freeze();
  EXPECT_EQ(known_cells(grid.view()), before);
  EXPECT_EQ(grid.view().origin, origin);
  EXPECT_EQ(grid.view().cell_m, cell_m);
}

TEST(LogOddsGrid, AFrozenGridTakesOneByteACell) {
  LogOddsGrid grid(cell_m, usual_model);
  EXPECT_EQ(grid.bytes(), 0U);
  const std::vector<Eigen::Vector2d> returns{middle_of({5, 3}), middle_of({-6, 2})};
  grid.insert(middle_of({0, 0}), returns);
  const auto cells = static_cast<std::size_t>(grid.view().width) * static_cast<std::size_t>(grid.view().height);
  EXPECT_EQ(grid.bytes(), 7 * cells);
  grid.freeze();
  EXPECT_EQ(grid.bytes(), cells);
}

}  // namespace
}  // namespace rastro
