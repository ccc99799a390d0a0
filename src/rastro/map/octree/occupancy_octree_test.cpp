// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/octree/occupancy_octree.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <memory>
#include <set>
#include <sstream>

#include "rastro/map/grid/slice.h"
#include "rastro/map/images/room_map_testing.h"
#include "rastro/map/octree/ray_cells.h"

namespace rastro {
namespace {

using Eigen::Vector3d;

OctreeOptions options() {
  OctreeOptions options;
  options.stride = 3;
  return options;
}

/// Made once, since every test only reads it.
const OccupancyOctree& room() {
  static const OccupancyOctree octree = build_octree(make_test_map(6), options());
  return octree;
}

TEST(OccupancyOctree, KnowsWallsFreeSpaceAndOccludedSpace) {
  const OccupancyOctree& octree = room();
  // The wall ahead, the floor and the box's top are hit by several keyframes; 0.7 twice is 0.845.
  EXPECT_GT(octree.occupancy_at({1.99, 0.1, 1.0}).value_or(0.0), 0.8) << "a cube whose far side is the wall";
  EXPECT_GT(octree.occupancy_at({0.4, 0.1, -0.01}).value_or(octree.occupancy_at({0.4, 0.1, 0.01}).value_or(0.0)), 0.8);
  EXPECT_LT(octree.occupancy_at({0.0, 0.0, 1.0}).value_or(1.0), 0.2) << "air before the cameras";
  EXPECT_FALSE(octree.occupancy_at({1.2, 0.2, 0.3})) << "inside the box";
  EXPECT_FALSE(octree.occupancy_at({2.5, 0.0, 1.0})) << "behind the wall";
  for (const double far : {1e9, -1e9, std::nan("")}) EXPECT_FALSE(octree.occupancy_at({1.0, far, 1.0})) << far;
  EXPECT_FALSE(octree.occupancy_at({1e9, 0.0, 1.0}));
  EXPECT_GT(octree.occupied_leaves(), 1000U);
  EXPECT_GT(octree.free_leaves(), 1000U);
}

TEST(OccupancyOctree, ClampsAndCountsByTheModel) {
  const OccupancyOctree one = build_octree(make_test_map(1), options());
  const SE3 pose = test_room::world_from_camera(0, 1);
  const Vector3d ahead = pose * Vector3d(0.0, 0.0, 0.5);
  EXPECT_NEAR(one.occupancy_at(ahead).value_or(-1.0), 0.4, 1e-6) << "one miss";
  EXPECT_NEAR(room().occupancy_at({0.0, 0.0, 1.0}).value_or(-1.0), 0.1192, 1e-3) << "six misses stop at the clamp";
}

TEST(OccupancyOctree, IsReadByOctoMapFromBothFormats) {
  const OccupancyOctree& octree = room();
  std::istringstream ot_stream(octree.ot_bytes()), bt_stream(octree.bt_bytes());
  const std::unique_ptr<octomap::AbstractOcTree> ot(octomap::AbstractOcTree::read(ot_stream));
  const auto* probabilities = dynamic_cast<octomap::OcTree*>(ot.get());
  octomap::OcTree decided(0.1);
  ASSERT_NE(probabilities, nullptr);
  ASSERT_TRUE(decided.readBinary(bt_stream));
  for (const Vector3d& position : {Vector3d(1.99, 0.1, 1.0), Vector3d(0.0, 0.0, 1.0), Vector3d(0.0, 0.0, 9.0)}) {
    const auto expected = octree.occupancy_at(position);
    const auto* fine = probabilities->search(position.x(), position.y(), position.z());
    const auto* coarse = decided.search(position.x(), position.y(), position.z());
    ASSERT_EQ(expected.has_value(), fine != nullptr);
    ASSERT_EQ(expected.has_value(), coarse != nullptr);
    if (!expected) continue;
    EXPECT_NEAR(fine->getOccupancy(), *expected, 1e-6);
    EXPECT_EQ(coarse->getOccupancy() > 0.5, *expected > 0.5);
  }
}

TEST(OccupancyOctree, ListsItsOccupiedCubes) {
  const OccupancyOctree& octree = room();
  const std::vector<OctreeCube> cubes = octree.occupied_cubes();
  ASSERT_EQ(cubes.size(), octree.occupied_leaves());
  for (const OctreeCube& cube : cubes) {
    ASSERT_GE(cube.side_m, 0.99 * octree.resolution_m());
    ASSERT_GT(octree.occupancy_at(cube.center).value_or(0.0), 0.5);
    ASSERT_GT(octree.occupancy_at(cube.center + Vector3d::Constant(0.49 * cube.side_m)).value_or(0.0), 0.5);
  }
}

TEST(OccupancyOctree, GivesTheSameBytesForAnyPool) {
  const Map map = make_test_map(9);
  const OctreeOptions coarse{.resolution_m = 0.1};
  const std::string alone = build_octree(map, coarse).ot_bytes();
  for (const int threads : {1, 2, 8}) {
    TaskPool pool(threads);
    EXPECT_TRUE(build_octree(map, coarse, &pool).ot_bytes() == alone) << threads;
  }
}

TEST(RayCells, PassEveryCubeThatARayCrossesAndNoOther) {
  const Vector3d origin(0.013, 0.027, -0.041), end(1.37, -0.83, 0.55);
  detail::RayCells cells(origin, 0.1);
  cells.add(end, true);
  cells.finish();
  std::set<detail::CellKey> crossed;
  const auto key = [](const Vector3d& position) {
    const Eigen::Vector3d cell = (position / 0.1).array().floor() + 32768.0;
    return static_cast<detail::CellKey>(cell.x()) | static_cast<detail::CellKey>(cell.y()) << 16 |
           static_cast<detail::CellKey>(cell.z()) << 32;
  };
  for (int k = 0; k <= 200000; ++k) crossed.insert(key(origin + (k / 200000.0) * (end - origin)));
  EXPECT_EQ(cells.hits(), std::vector<detail::CellKey>{key(end)});
  crossed.erase(key(end));
  EXPECT_EQ(std::vector<detail::CellKey>(crossed.begin(), crossed.end()), cells.free());
}

TEST(Slice, ShowsWallsAndTheBoxFromAbove) {
  const OccupancyOctree& octree = room();
  const OccupancyGrid low = slice_between(octree, 0.1, 0.5), high = slice_between(octree, 0.8, 1.2);
  const auto at = [](const OccupancyGrid& grid, double x, double y) {
    const Eigen::Vector2i cell = grid.cell_of({x, y});
    return grid.holds(cell.x(), cell.y()) ? grid.at(cell.x(), cell.y()) : OccupancyGrid::unknown;
  };
  EXPECT_GT(at(low, 0.96, 0.1), 60) << "the box's front";
  EXPECT_LT(at(high, 1.2, 0.1), 40) << "nothing above the box";
  EXPECT_GE(at(high, 1.2, 0.1), 0);
  EXPECT_GT(at(high, 1.99, 0.1), 60) << "the wall";
  EXPECT_LT(at(low, 0.5, 0.0), 40);
  EXPECT_EQ(at(low, -1.9, -1.4), OccupancyGrid::unknown) << "behind the cameras";
}

}  // namespace
}  // namespace rastro
