// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/grid/occupancy_mapper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/map/grid/dense_grid_testing.h"

namespace rastro {
namespace {

constexpr double mapper_cell_m = 0.05;
const LogOddsModel mapper_model{0.85, 0.4, 6.0};

struct TestScan {
  Eigen::Vector2d sensor;
  std::vector<Eigen::Vector2d> returns;
};

TestScan random_scan(const Eigen::Vector2d& middle, int beams, Random& random) {
  TestScan scan{middle + Eigen::Vector2d(random.uniform(-5.0, 5.0), random.uniform(-5.0, 5.0)), {}};
  for (int k = 0; k < beams; ++k) {
    const double angle = random.uniform(-M_PI, M_PI), range = random.uniform(0.0, 12.0);
    scan.returns.emplace_back(scan.sensor + range * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return scan;
}

/// Of the same scans in OccupancyMapper and in the grid that holds every cell.
void expect_same_grid(const std::vector<TestScan>& scans, const LogOddsModel& model) {
  OccupancyMapper mapper(mapper_cell_m, model);
  LogOddsGrid dense(mapper_cell_m, model);
  for (const TestScan& scan : scans) {
    mapper.insert(scan.sensor, scan.returns);
    dense.insert(scan.sensor, scan.returns);
  }
  const OccupancyGrid grid = mapper.grid(), expected = to_occupancy(dense.view());
  EXPECT_EQ(grid.cell_m, expected.cell_m);
  EXPECT_EQ(grid.origin, expected.origin);
  EXPECT_EQ(grid.width, expected.width);
  EXPECT_EQ(grid.height, expected.height);
  EXPECT_TRUE(grid.percent == expected.percent);
  EXPECT_GT(expected.percent.tiles(), 0U);
}

TEST(OccupancyMapper, GivesWhatTheGridOfAllCellsGives) {
  Random random(3);
  for (const LogOddsModel& model : {mapper_model, LogOddsModel(), LogOddsModel{0.6, 0.45, 1.0}}) {
    std::vector<TestScan> scans;
    for (int k = 0; k < 30; ++k) scans.push_back(random_scan({1.5 * k - 20.0, 13.0 - k}, 80, random));
    expect_same_grid(scans, model);
  }
}

TEST(OccupancyMapper, CountsMoreScansThanACellHasNumbersFor) {
  Random random(4);
  std::vector<TestScan> scans;
  for (int k = 0; k < 33'000; ++k) scans.push_back(random_scan({0.0, 0.0}, 3, random));
  expect_same_grid(scans, mapper_model);
}

TEST(OccupancyMapper, LeavesOutReturnsTooFarAway) {
  expect_same_grid({{{0.0, 0.0}, {{32768 * mapper_cell_m + 1.0, 0.0}, {1.0, 1.0}}}}, mapper_model);
}

TEST(OccupancyMapper, TwoRoomsTenKilometersApartHoldFewTiles) {
  OccupancyMapper mapper(mapper_cell_m, mapper_model);
  Random random(6);
  for (const Eigen::Vector2d& middle : {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(7000.0, -7200.0)})
    for (int k = 0; k < 20; ++k) {
      const TestScan scan = random_scan(middle, 100, random);
      mapper.insert(scan.sensor, scan.returns);
    }
  // A room is at most 34 x 34 m; the box of both has 5 million tiles.
  const double tile_m = TiledCells<std::int8_t>::side * mapper_cell_m, most_a_room = std::pow(34.0 / tile_m + 2.0, 2);
  EXPECT_LE(static_cast<double>(mapper.tiles()), 2.0 * most_a_room);
  const OccupancyGrid grid = mapper.grid();
  EXPECT_GT(static_cast<double>(grid.width) * grid.height, 1e10);
  EXPECT_LE(static_cast<double>(grid.percent.tiles()), 2.0 * most_a_room);
  const Eigen::Vector2i between = grid.cell_of({3500.0, -3600.0});
  EXPECT_EQ(grid.at(between.x(), between.y()), OccupancyGrid::unknown);
}

TEST(OccupancyMapper, GivesPercentWhereABeamPassed) {
  OccupancyMapper mapper(mapper_cell_m, {0.8, 0.3, 6.0});
  const std::vector<Eigen::Vector2d> returns{{-0.125, 0.225}};
  mapper.insert({-0.125, 0.025}, returns);
  const OccupancyGrid grid = mapper.grid();
  const auto percent_at = [&](double x, double y) {
    const Eigen::Vector2i cell = grid.cell_of({x, y});
    return static_cast<int>(grid.at(cell.x(), cell.y()));
  };
  EXPECT_EQ(percent_at(-0.125, 0.225), 80);
  EXPECT_EQ(percent_at(-0.125, 0.125), 30);
  EXPECT_EQ(percent_at(-0.075, 0.125), OccupancyGrid::unknown);
  int known = 0;
  grid.percent.for_each([&](int, int, std::int8_t percent) { known += percent != OccupancyGrid::unknown ? 1 : 0; });
  EXPECT_EQ(known, 5);
}

}  // namespace
}  // namespace rastro
