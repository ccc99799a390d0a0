// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/scans/scan_layer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>

#include "rastro/base/random.h"
#include "rastro/map/graph/planar.h"
#include "rastro/map/grid/dense_grid_testing.h"

namespace rastro {
namespace {

/// Keyframes with two scans each, the last one in a submap of its own.
Map map_of_scans(int keyframes) {
  Random random(41);
  Map map;
  auto scans = std::make_shared<ScanLayer>();
  scans->cell_m = 0.1;
  scans->model.free_probability = 0.3;
  for (int k = 0; k < keyframes; ++k) {
    const SE2 pose(SO2::from_angle(0.3 * k), {0.5 * k, -0.25 * k});
    map.keyframes.push_back({7 * k, k, k, 0, in_space(pose), k + 1 == keyframes ? 1 : 0, no_keyframe, 1.0});
    auto of_keyframe = std::make_shared<KeyframeScans>(2);
    for (KeyframeScan& scan : *of_keyframe) {
      scan.sensor = {0.15, 0.0};
      for (int i = 0; i < 200; ++i) {
        const double angle = random.uniform(-2.0, 2.0), range = random.uniform(1.0, 5.0);
        scan.points.emplace_back(range * std::cos(angle), range * std::sin(angle));
      }
    }
    scans->of[7 * k] = of_keyframe;
  }
  map.layers.put<ScanLayer>(std::move(scans));
  return map;
}

/// The grid of the scans of these keyframes, inserted one after the other.
OccupancyGrid filled_directly(const Map& map, const std::vector<std::size_t>& keyframes) {
  const auto layer = map.layer<ScanLayer>();
  LogOddsGrid grid(layer->cell_m, layer->model);
  for (const std::size_t k : keyframes) {
    const SE2 world_from_body = in_plane(map.keyframes[k].world_from_camera);
    for (const KeyframeScan& scan : *layer->find(map.keyframes[k].id)) {
      std::vector<Eigen::Vector2d> returns;
      for (const Eigen::Vector2d& point : scan.points) returns.push_back(world_from_body * point);
      grid.insert(world_from_body * scan.sensor, returns);
    }
  }
  return to_occupancy(grid.view());
}

void expect_same(const OccupancyGrid& a, const OccupancyGrid& b) {
  EXPECT_EQ(a.cell_m, b.cell_m);
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.percent, b.percent);
}

TEST(OccupancyGridOfAMap, IsTheOneFilledWithItsScans) {
  Map map = map_of_scans(4);
  const auto grid = occupancy_grid_of(map);
  ASSERT_TRUE(grid);
  EXPECT_GT(grid->width, 20);
  expect_same(*grid, filled_directly(map, {0, 1, 2}));
  expect_same(*occupancy_grid_of(map, 1), filled_directly(map, {3}));
  map.keyframes[1].world_from_camera = in_space(SE2(SO2::from_angle(-1.0), {3.0, 2.0}));
  expect_same(*occupancy_grid_of(map), filled_directly(map, {0, 1, 2}));
  EXPECT_NE(occupancy_grid_of(map)->percent, grid->percent) << "it follows the map";
}

TEST(OccupancyGridOfAMap, SkipsKeyframesWithoutScans) {
  Map map = map_of_scans(4);
  auto scans = std::make_shared<ScanLayer>(*map.layer<ScanLayer>());
  scans->of.erase(7);
  map.layers.put<ScanLayer>(std::move(scans));
  expect_same(*occupancy_grid_of(map), filled_directly(map, {0, 2}));
  map.layers.put<ScanLayer>(nullptr);
  EXPECT_FALSE(occupancy_grid_of(map));
}

TEST(ScanLayer, ShowsItsReturnsAtTheCurrentPoses) {
  const Map map = map_of_scans(3);
  const PointCloud cloud = layer_points(map, 0);
  ASSERT_EQ(cloud.points.size(), 800U);
  EXPECT_EQ(layer_points(map, -1).points.size(), 1200U);
  std::size_t next = 0;
  for (std::size_t k = 0; k < 2; ++k) {
    for (const KeyframeScan& scan : *map.layer<ScanLayer>()->find(map.keyframes[k].id)) {
      for (const Eigen::Vector2d& point : scan.points) {
        const Eigen::Vector2d expected = in_plane(map.keyframes[k].world_from_camera) * point;
        const Eigen::Vector3d shown = cloud.points[next++].position.cast<double>();
        EXPECT_LT((shown - Eigen::Vector3d(expected.x(), expected.y(), 0.0)).norm(), 1e-5);
      }
    }
  }
}

}  // namespace
}  // namespace rastro
