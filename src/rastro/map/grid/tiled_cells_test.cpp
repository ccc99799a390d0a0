// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/grid/tiled_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "rastro/base/random.h"

namespace rastro {
namespace {

constexpr int unwritten = -7;
/// As (y, x), so that they are ordered row by row.
using PlainCells = std::map<std::pair<int, int>, int>;

int value_in(const PlainCells& cells, int x, int y) {
  const auto found = cells.find({y, x});
  return found == cells.end() ? unwritten : found->second;
}

/// The same random cells, held in tiles and one by one.
struct BothCells {
  TiledCells<int> tiled{unwritten};
  PlainCells plain;
};

BothCells random_cells() {
  BothCells both;
  Random random(5);
  TiledCells<int>::Writer writer(both.tiled);
  for (int k = 0; k < 3000; ++k) {
    const int x = static_cast<int>(random.below(600)) - 300, y = static_cast<int>(random.below(400)) - 250;
    writer.at(x, y) = both.plain[{y, x}] = k;
  }
  return both;
}

TEST(TiledCells, HoldsWhatWasWrittenAtAnySideOfTheOrigin) {
  const auto [tiled, plain] = random_cells();
  for (int y = -320; y < 320; ++y)
    for (int x = -320; x < 320; ++x) ASSERT_EQ(tiled.at(x, y), value_in(plain, x, y)) << x << ' ' << y;
}

TEST(TiledCells, GivesTheCellsRowByRow) {
  const auto [tiled, plain] = random_cells();
  std::vector<std::pair<int, int>> order;
  PlainCells visited;
  tiled.for_each([&, &all = plain](int x, int y, int value) {
    EXPECT_EQ(value, value_in(all, x, y));
    order.emplace_back(y, x);
    if (value != unwritten) visited[{y, x}] = value;
  });
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
  EXPECT_EQ(visited, plain);
}

TEST(TiledCells, CopiesAnyPartOfARow) {
  const auto [tiled, plain] = random_cells();
  for (const int first_x : {-400, -300, -65, -64, -1, 0, 1, 63, 64, 250, 500}) {
    for (const std::size_t width : {0, 1, 63, 64, 65, 700}) {
      for (int y = -260; y < 160; y += 7) {
        std::vector<int> row(width, 1), expected;
        tiled.copy_row(first_x, y, row);
        for (int x = first_x; x < first_x + static_cast<int>(width); ++x) expected.push_back(value_in(plain, x, y));
        ASSERT_EQ(row, expected) << first_x << ' ' << width << ' ' << y;
      }
    }
  }
}

TEST(TiledCells, TakesMemoryWhereItIsWrittenOnly) {
  TiledCells<int> cells(unwritten);
  EXPECT_EQ(cells.at(3, 4), unwritten);
  EXPECT_EQ(cells.tiles(), 0U) << "reading holds no tile";
  constexpr int far = 1'000'000'000;
  for (const auto& [x, y] : {std::pair{0, 0}, {63, 63}, {-far, far}, {-far + 1, far}, {far, -far}}) cells.set(x, y, 1);
  EXPECT_EQ(cells.tiles(), 3U);
  EXPECT_EQ(cells.at(-far, far), 1);
  EXPECT_EQ(cells.at(far, far), unwritten);
}

TEST(TiledCells, ACopyIsIndependent) {
  TiledCells<int> cells(unwritten);
  cells.set(1, 2, 3);
  TiledCells<int> copy = cells;
  EXPECT_EQ(copy, cells);
  copy.set(1, 2, 4);
  EXPECT_EQ(cells.at(1, 2), 3);
  EXPECT_NE(copy, cells);
  copy.change_each([](int& cell) { cell = 9; });
  EXPECT_EQ(copy.at(1, 2), 9);
  EXPECT_EQ(copy.at(2, 2), 9) << "of the same tile";
  EXPECT_EQ(copy.at(64, 2), unwritten) << "of none";
}

}  // namespace
}  // namespace rastro
