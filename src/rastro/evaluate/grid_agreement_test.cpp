// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/grid_agreement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace rastro {
namespace {

OccupancyGrid unknown_grid(int width, int height, double cell_m, const Eigen::Vector2d& origin) {
  OccupancyGrid grid;
  grid.cell_m = cell_m;
  grid.origin = origin;
  grid.width = width;
  grid.height = height;
  return grid;
}

void set(OccupancyGrid& grid, int x, int y, std::int8_t percent) { grid.percent.set(x, y, percent); }

/// A room of 8 x 5 m with walls 0.3 m thick and a box in a corner, as mapped by a robot at map_from_room.
OccupancyGrid room(const SE2& map_from_room = {}, double cell_m = 0.05) {
  const int size = static_cast<int>(std::lround(14.0 / cell_m));
  OccupancyGrid grid = unknown_grid(size, size, cell_m, {-7.0, -7.0});
  const SE2 room_from_map = map_from_room.inverse();
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const Eigen::Vector2d at = room_from_map * grid.center_of(x, y);
      const Eigen::Vector2d outside = at.cwiseAbs() - Eigen::Vector2d(4.0, 2.5);
      const bool box = at.x() > 2.0 && at.y() > 1.2 && at.x() < 3.1 && at.y() < 1.7;
      if (outside.maxCoeff() < 0.0) set(grid, x, y, box ? 100 : 0);
      if (outside.maxCoeff() >= 0.0 && outside.maxCoeff() < 0.3) set(grid, x, y, 100);
    }
  }
  return grid;
}

TEST(GridAgreement, IsCompleteForTheSameMap) {
  const OccupancyGrid map = room();
  const GridAgreement same = grid_agreement(map, map, {.tolerance_cells = 0.0});
  EXPECT_EQ(same.precision, 1.0);
  EXPECT_EQ(same.recall, 1.0);
  EXPECT_EQ(same.iou, 1.0);
  EXPECT_EQ(same.free_agreement, 1.0);
  EXPECT_EQ(same.explored, 1.0);
  EXPECT_LT(same.ground_truth_occupied, same.map_occupied) << "the inside of walls cannot be observed";
}

TEST(GridAgreement, CountsByHand) {
  OccupancyGrid ground_truth = unknown_grid(6, 3, 1.0, {0.0, 0.0}), map = ground_truth;
  for (int x = 0; x < 6; ++x) {
    set(ground_truth, x, 2, 100);
    set(ground_truth, x, 1, 0);
  }
  set(map, 0, 2, 100);  // right
  set(map, 1, 2, 100);  // right
  set(map, 2, 0, 100);  // two cells beside a wall
  set(map, 3, 1, 0);    // right
  set(map, 4, 2, 0);    // a wall mapped as free
  const GridAgreement strict = grid_agreement(map, ground_truth, {.tolerance_cells = 0.0});
  EXPECT_EQ(strict.map_occupied, 3);
  EXPECT_EQ(strict.ground_truth_occupied, 6);
  EXPECT_EQ(strict.ground_truth_seen, 3);
  EXPECT_DOUBLE_EQ(strict.precision, 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(strict.recall, 2.0 / 6.0);
  EXPECT_DOUBLE_EQ(strict.recall_seen, 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(strict.iou, 0.5);
  EXPECT_DOUBLE_EQ(strict.free_agreement, 0.5);
  EXPECT_DOUBLE_EQ(strict.explored, 1.0 / 6.0);
  const GridAgreement lax = grid_agreement(map, ground_truth, {.tolerance_cells = 2.0});
  EXPECT_DOUBLE_EQ(lax.precision, 1.0);
  EXPECT_DOUBLE_EQ(lax.free_agreement, 1.0);
}

TEST(GridAgreement, DropsWhenTheMapIsMoved) {
  const GridAgreement near = grid_agreement(room({SO2(), {0.05, 0.0}}), room(), {});
  EXPECT_EQ(near.precision, 1.0) << "one cell is within the tolerance";
  const GridAgreement far = grid_agreement(room({SO2(), {0.4, 0.0}}), room(), {});
  EXPECT_LT(far.iou, 0.8);
}

TEST(GridAgreement, AcceptsCellsOfAnotherSize) {
  const GridAgreement finer = grid_agreement(room({}, 0.02), room(), {});
  EXPECT_GT(finer.precision, 0.99);
  EXPECT_GT(finer.recall_seen, 0.99);
}

TEST(GridAgreement, FindsThePoseOfTheMap) {
  const SE2 map_from_room(SO2::from_angle(0.05), {0.5, -0.3});
  const GridAgreement found = grid_agreement(room(map_from_room), room(), {.align = true});
  const SE2 left = found.ground_truth_from_map * map_from_room;
  EXPECT_LT(left.translation().norm(), 0.05);
  EXPECT_LT(std::abs(left.rotation().angle()), 0.01);
  EXPECT_GT(found.iou, 0.95);
  EXPECT_GT(found.iou, grid_agreement(room(map_from_room), room(), {}).iou + 0.2);
}

TEST(GridAgreement, IsZeroForMapsWithoutWalls) {
  const OccupancyGrid nothing = unknown_grid(4, 4, 0.05, {0.0, 0.0}), empty;
  for (const OccupancyGrid& map : {nothing, empty}) {
    const GridAgreement agreement = grid_agreement(map, room(), {.align = true});
    EXPECT_EQ(agreement.precision, 0.0);
    EXPECT_EQ(agreement.iou, 0.0);
    EXPECT_EQ(grid_agreement(room(), map, {.align = true}).iou, 0.0);
  }
}

}  // namespace
}  // namespace rastro
