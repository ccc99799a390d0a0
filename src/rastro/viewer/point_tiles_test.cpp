// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/point_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "rastro/base/random.h"
#include "rastro/viewer/scene_block_testing.h"
#include "rastro/viewer/scene_writer.h"

namespace rastro {
namespace {

/// On the sides of a box of 20 x 10 x 3 m; the number of a point is its color and its row.
ScenePoints room(std::size_t count) {
  Random random(7);
  ScenePoints points;
  points.name = "cloud";
  for (std::size_t k = 0; k < count; ++k) {
    std::array<double, 3> at{random.uniform(0.0, 20.0), random.uniform(0.0, 10.0), random.uniform(0.0, 3.0)};
    const std::size_t axis = k % 3;
    at[axis] = k % 2 == 0 ? 0.0 : std::array{20.0, 10.0, 3.0}[axis];
    for (const double each : at) points.positions.push_back(static_cast<float>(each));
    for (const int shift : {0, 8, 16}) points.colors.push_back(static_cast<std::uint8_t>(k >> shift));
    points.keyframes.push_back(static_cast<std::uint32_t>(k));
  }
  return points;
}

TEST(PointTiles, EveryPointIsInOneTileAndInsideItsCube) {
  constexpr std::size_t count = 400'000;
  const ScenePoints all = room(count);
  std::size_t done = 0;
  const PointTiles tiles(all, [&](std::size_t placed, std::size_t of) {
    EXPECT_GT(placed, done);
    EXPECT_EQ(of, count);
    done = placed;
  });
  EXPECT_EQ(done, count);
  const SceneTiles& index = tiles.index();
  ASSERT_GT(index.counts.size(), 10U);
  EXPECT_EQ(index.count, count);
  std::vector<int> seen(count, 0);
  for (std::size_t row = 0; row < index.counts.size(); ++row) {
    const ScenePoints tile = tiles.tile(row);
    ASSERT_LE(tile.keyframes.size(), PointTiles::most_points);
    ASSERT_EQ(tile.keyframes.size(), index.counts[row]);
    EXPECT_TRUE(row == 0 ? index.parents[0] == -1 : index.parents[row] < static_cast<int>(row));
    for (std::size_t k = 0; k < tile.keyframes.size(); ++k) {
      const std::size_t number = tile.keyframes[k];
      ++seen[number];
      ASSERT_EQ(tile.colors[3 * k + 1], static_cast<std::uint8_t>(number >> 8));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ASSERT_EQ(tile.positions[3 * k + axis], all.positions[3 * number + axis]);
        ASSERT_LE(std::abs(tile.positions[3 * k + axis] - index.cubes[4 * row + axis]),
                  1.00001F * index.cubes[4 * row + 3]);
      }
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(count));
}

TEST(PointTiles, TheRootShowsAllOfItEvenly) {
  const PointTiles tiles(room(400'000));
  const ScenePoints root = tiles.tile(0);
  EXPECT_EQ(root.keyframes.size(), PointTiles::most_points);
  std::set<std::pair<int, int>> floor;  // squares of 1 m
  for (std::size_t k = 0; k < root.keyframes.size(); ++k)
    if (root.positions[3 * k + 2] == 0.0F)
      floor.emplace(static_cast<int>(root.positions[3 * k]), static_cast<int>(root.positions[3 * k + 1]));
  EXPECT_EQ(floor.size(), 200U);
}

TEST(PointTiles, AFewPointsFarAwayTakeNothingFromTheRoot) {
  ScenePoints points = room(400'000);
  for (const float far : {-9e4F, 9e4F}) points.positions.insert(points.positions.end(), {far, far, far});
  points.colors.clear();
  points.keyframes.clear();
  const ScenePoints root = PointTiles(points).tile(0);
  EXPECT_EQ(root.positions.size(), 3 * PointTiles::most_points);
  EXPECT_LE(std::count_if(root.positions.begin(), root.positions.end(), [](float each) { return each > 100.0F; }), 3);
}

TEST(PointTiles, PointsInOnePlaceAndPointsThatAreNoneDoNoHarm) {
  ScenePoints points;
  points.positions.assign(std::size_t{3} * 100'000, 1.5F);
  points.positions[0] = std::numeric_limits<float>::quiet_NaN();
  const PointTiles tiles(points);
  EXPECT_EQ(tiles.index().count, 99'999U);
  std::size_t sum = 0;
  for (const std::uint32_t each : tiles.index().counts) sum += each;
  EXPECT_EQ(sum, 99'999U);
  EXPECT_EQ(PointTiles(ScenePoints{}).index().count, 0U);
}

TEST(PointTiles, LargeLayersOfASceneAreTiledTheOthersStay) {
  ViewScene scene;
  scene.layers = {room(100), room(100'000)};
  EXPECT_FALSE(tile_large_layers(scene, 100'000));
  const auto tile_block = tile_large_layers(scene, 50'000);
  ASSERT_TRUE(tile_block);
  const SceneBlock block(scene_bytes(scene));
  const auto& layers = block.header.at("layers");
  EXPECT_FALSE(layers[0].contains("tiles"));
  const auto& tiles = layers[1].at("tiles");
  EXPECT_EQ(tiles.at("count"), 100'000);
  const auto counts = block.numbers<std::uint32_t>(tiles.at("counts"));
  ASSERT_GT(counts.size(), 1U);
  EXPECT_EQ(block.numbers<float>(layers[1].at("positions")).size(), std::size_t{3} * counts[0]);
  const std::string bytes = tile_block(0, 1).value_or("");
  const SceneBlock tile(bytes);
  EXPECT_EQ(tile.header.at("type"), "tile");
  EXPECT_EQ(tile.numbers<std::uint32_t>(tile.header.at("keyframes")).size(), counts[1]);
  EXPECT_FALSE(tile_block(0, counts.size()));
  EXPECT_FALSE(tile_block(1, 0));
}

}  // namespace
}  // namespace rastro
