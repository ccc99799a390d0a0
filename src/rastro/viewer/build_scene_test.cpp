// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/build_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "rastro/map/cloud/build_cloud.h"
#include "rastro/map/graph/covisibility.h"
#include "rastro/map/images/room_map_testing.h"
#include "rastro/map/landmarks/landmark_map_testing.h"
#include "rastro/map/landmarks/landmark_uncertainty.h"
#include "rastro/map/scans/scan_layer.h"
#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/viewer/scene_block_testing.h"
#include "rastro/viewer/scene_writer.h"

namespace rastro {
namespace {

using ::testing::Contains;
using ::testing::Not;

std::string bytes_of(const Map& map, const ViewSceneOptions& options = {}, int threads = 1) {
  TaskPool pool(threads);
  return scene_bytes(build_scene(map, options, pool));
}

std::vector<float> floats(const Eigen::Vector3d& vector) {
  return {static_cast<float>(vector.x()), static_cast<float>(vector.y()), static_cast<float>(vector.z())};
}

/// Item k of an array of `size` numbers each.
std::vector<float> item(const std::vector<float>& numbers, std::size_t k, std::size_t size) {
  const auto begin = numbers.begin() + static_cast<std::ptrdiff_t>(k * size);
  return {begin, begin + static_cast<std::ptrdiff_t>(size)};
}

std::vector<std::uint32_t> pairs_of(const SceneBlock& block, const std::string& name) {
  return block.layer(name) ? block.numbers<std::uint32_t>(block.layer(name)->at("pairs"))
                           : std::vector<std::uint32_t>{};
}

/// Three keyframes along x, each with one scan of a wall at y = 2.
Map planar_map(double step_m = 0.5) {
  Map map;
  map.method = "hector";
  map.sessions.push_back({0, 0, "/data/office/", 0, ns_per_second, {true, 0.0, "laser"}});
  auto scans = std::make_shared<ScanLayer>();
  for (int k = 0; k < 3; ++k) {
    map.keyframes.push_back({k, k, k * ns_per_second, 0, SE3(SO3(), {step_m * k, 0.0, 0.0}), k == 2 ? 1 : 0});
    auto of_keyframe = std::make_shared<KeyframeScans>(1);
    for (int beam = -20; beam <= 20; ++beam) of_keyframe->front().points.emplace_back(0.1 * beam, 2.0);
    scans->of[k] = of_keyframe;
  }
  map.layers.put<ScanLayer>(std::move(scans));
  return map;
}

TEST(BuildScene, HasTheRoomAsTheMapHasIt) {
  const Map map = make_test_map(6);
  const std::string bytes = bytes_of(map);
  const SceneBlock block(bytes);
  EXPECT_EQ(block.header["method"], "rgbd");
  EXPECT_EQ(block.header["planar"], false);
  EXPECT_EQ(block.header["scale"]["kind"], "metric");
  EXPECT_EQ(block.header["camera"]["fx"], 260.0);
  const auto poses = block.numbers<float>(block.header["keyframes"]["poses"]);
  ASSERT_EQ(poses.size(), 7 * map.keyframes.size());
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    const SE3& pose = map.keyframes[k].world_from_camera;
    EXPECT_EQ(item({poses.begin() + static_cast<std::ptrdiff_t>(7 * k), poses.end()}, 0, 3),
              floats(pose.translation()));
    EXPECT_EQ(poses[7 * k + 6], static_cast<float>(pose.rotation().quaternion().w()));
  }
  EXPECT_EQ(pairs_of(block, "odometry"), (std::vector<std::uint32_t>{0, 1, 1, 2, 2, 3, 3, 4, 4, 5}));
  EXPECT_EQ(pairs_of(block, "loops"), (std::vector<std::uint32_t>{5, 0}));
}

TEST(BuildScene, HasTheFramesOfTheMap) {
  const Map map = make_test_map(6);
  const std::string bytes = bytes_of(map);
  const SceneBlock block(bytes);
  const Trajectory trajectory = trajectory_of(map);
  const auto& frames = block.header["frames"];
  const auto stamps = block.numbers<double>(frames["stamps"]);
  const auto positions = block.numbers<float>(frames["positions"]);
  ASSERT_EQ(stamps.size(), trajectory.size());
  ASSERT_EQ(positions.size(), 3 * trajectory.size());
  EXPECT_EQ(block.numbers<float>(frames["orientations"]).size(), 4 * trajectory.size());
  for (std::size_t k = 0; k < stamps.size(); ++k) {
    EXPECT_EQ(stamps[k], to_seconds(trajectory[k].stamp));
    EXPECT_EQ(item(positions, k, 3), floats(trajectory[k].world_from_body.translation()));
  }
}

/// As where a map is continued by a method that numbers keyframes on.
TEST(BuildScene, KeyframesNumberedOnAreOfTheirSessions) {
  Map map = make_test_map(4);
  const TimeNs first = map.keyframes.front().stamp, last = map.keyframes.back().stamp;
  map.sessions = {{0, 0, "first", first, last, {}}, {0, 1, "second", first, last, {}}};
  map.keyframes[2].stamp = first;
  map.keyframes[3].stamp = first + 1;
  TaskPool pool(1);
  EXPECT_EQ(build_scene(map, {}, pool).keyframes.sessions, (std::vector<std::int32_t>{0, 0, 1, 1}));
}

TEST(BuildScene, ThinsTheCloudAndFindsUp) {
  const Map map = make_test_map(6);
  const PointCloud cloud = build_cloud(map, cloud_options_for(map));
  const std::string whole = bytes_of(map);
  const SceneBlock all(whole);
  EXPECT_EQ(all.numbers<float>(all.layer("cloud")->at("positions")).size(), 3 * cloud.points.size());
  EXPECT_EQ(item(all.numbers<float>(all.layer("cloud")->at("positions")), 5, 3),
            floats(cloud.points[5].position.cast<double>()));
  EXPECT_EQ(all.numbers<std::uint8_t>(all.layer("cloud")->at("colors"))[2], cloud.points[0].color[2]);
  const auto up = all.header["up"].get<std::vector<double>>();
  EXPECT_GT(up[2], 0.999) << "the room stands upright in its world";
  ViewSceneOptions few;
  few.max_points = 500;
  const std::string thinned = bytes_of(map, few);
  const auto count = SceneBlock(thinned).layer("cloud")->at("sigmas").at("count").get<std::size_t>();
  EXPECT_LE(count, 500U);
  EXPECT_GE(count, 250U);
}

TEST(BuildScene, MakesSurfacesAndSmallImagesOnRequest) {
  const Map map = make_test_map(3);
  const std::string plain_bytes = bytes_of(map);
  const SceneBlock plain(plain_bytes);
  EXPECT_THAT(plain.layer_names(), Not(Contains("mesh")));
  EXPECT_THAT(plain.layer_names(), Not(Contains("octree")));
  EXPECT_TRUE(plain.header["images"].empty());
  ViewSceneOptions options;
  options.mesh = options.octree = true, options.max_images = 2;
  const std::string bytes = bytes_of(map, options);
  const SceneBlock block(bytes);
  const auto vertices = block.numbers<float>(block.layer("mesh")->at("positions")).size() / 3;
  for (const auto corner : block.numbers<std::uint32_t>(block.layer("mesh")->at("triangles")))
    ASSERT_LT(corner, vertices);
  EXPECT_GT(vertices, 100U);
  const auto sizes = block.numbers<float>(block.layer("octree")->at("sizes"));
  EXPECT_GT(sizes.size(), 100U);
  EXPECT_EQ(block.numbers<float>(block.layer("octree")->at("centers")).size(), 3 * sizes.size());
  ASSERT_EQ(block.header["images"].size(), 2U);
  EXPECT_EQ(block.header["images"][1]["keyframe"], 1);
  EXPECT_EQ(block.header["images"][0]["width"], 160) << "half of 320, as 240 is the limit";
  EXPECT_EQ(block.numbers<std::uint8_t>(block.header["images"][0]["jpeg"])[0], 0xFF);
}

TEST(BuildScene, HasLandmarksWithTheirGraphs) {
  const Map map = make_landmark_test_map();
  const std::string bytes = bytes_of(map);
  const SceneBlock block(bytes);
  EXPECT_EQ(block.header["scale"]["kind"], "arbitrary");
  const auto layer = map.layer<LandmarkLayer>();
  const auto& json = *block.layer("landmarks");
  const auto positions = block.numbers<float>(json.at("positions"));
  const auto sigmas = block.numbers<float>(json.at("sigmas"));
  const auto rows = block.numbers<std::uint32_t>(json.at("keyframes"));
  ASSERT_EQ(positions.size(), 3 * layer->landmarks.size());
  for (std::size_t k = 0; k < layer->landmarks.size(); ++k) {
    const Landmark& landmark = layer->landmarks[k];
    EXPECT_EQ(item(positions, k, 3), floats(landmark.position));
    EXPECT_EQ(map.keyframes[rows[k]].id, landmark.observations.front().keyframe);
    const auto covariance = landmark_covariance(map, landmark);
    ASSERT_EQ(std::isnan(sigmas[k]), !covariance) << k;
    if (covariance) {
      EXPECT_FLOAT_EQ(sigmas[k],
                      static_cast<float>(std::sqrt(landmark.direction.dot(*covariance * landmark.direction))));
    }
  }
  EXPECT_EQ(pairs_of(block, "covisibility").size(), 2 * covisibility_graph(map, ViewSceneOptions().covisible).size());
  EXPECT_EQ(pairs_of(block, "essential_graph").size(), 2 * essential_graph(map).size());
  EXPECT_EQ(pairs_of(block, "spanning_tree").size(), 2 * (map.keyframes.size() - 1));
  EXPECT_EQ(pairs_of(block, "loops"), (std::vector<std::uint32_t>{11, 0}));
}

TEST(BuildScene, GivesEllipsoidsTheSizeOfTheCovariance) {
  Map map = make_landmark_test_map();
  auto layer = std::make_shared<LandmarkLayer>();
  layer->landmarks.resize(1);
  layer->estimates.resize(1);
  layer->estimates[0].covariance = Eigen::Vector3d(0.04, 0.09, 0.0).asDiagonal();
  map.layers.put<LandmarkLayer>(std::move(layer));
  const std::string bytes = bytes_of(map);
  const SceneBlock block(bytes);
  const auto axes = block.numbers<float>(block.layer("landmark_covariances")->at("axes"));
  ASSERT_EQ(axes.size(), 9U);
  std::vector<float> lengths;
  for (std::size_t axis = 0; axis < 3; ++axis)
    lengths.push_back(std::hypot(axes[3 * axis], axes[3 * axis + 1], axes[3 * axis + 2]));
  EXPECT_THAT(lengths,
              ::testing::UnorderedElementsAre(::testing::FloatNear(0.0F, 1e-6F), ::testing::FloatNear(0.2F, 1e-6F),
                                              ::testing::FloatNear(0.3F, 1e-6F)));
  EXPECT_FLOAT_EQ(block.numbers<float>(block.layer("landmarks")->at("sigmas"))[0], std::sqrt(0.13F));
}

TEST(BuildScene, HasScansAndGridOfAPlanarMap) {
  const Map map = planar_map();
  const std::string bytes = bytes_of(map);
  const SceneBlock block(bytes);
  EXPECT_EQ(block.header["planar"], true);
  EXPECT_EQ(block.header["up"], (std::vector<double>{0.0, 0.0, 1.0}));
  EXPECT_EQ(block.header["sessions"][0]["name"], "office");
  EXPECT_FALSE(block.header.contains("camera"));
  EXPECT_EQ(block.numbers<std::int32_t>(block.header["keyframes"]["ids"]), (std::vector<std::int32_t>{0, 1}))
      << "the third keyframe is in another submap";
  const auto& grid = *block.layer("grid");
  const auto expected = occupancy_grid_of(map);
  const auto cells = block.numbers<std::uint8_t>(grid.at("cells"));
  ASSERT_EQ(grid.at("width"), expected->width);
  ASSERT_EQ(cells.size(), static_cast<std::size_t>(expected->width) * static_cast<std::size_t>(expected->height));
  for (int y = 0; y < expected->height; ++y) {
    for (int x = 0; x < expected->width; ++x) {
      const auto cell = cells[static_cast<std::size_t>(y * expected->width + x)];
      const int percent = expected->at(x, y);
      ASSERT_EQ(cell, percent < 0 ? 255 : std::lround(2.54 * percent)) << x << ' ' << y;
    }
  }
  const auto rows = block.numbers<std::uint32_t>(block.layer("scans")->at("keyframes"));
  const auto positions = block.numbers<float>(block.layer("scans")->at("positions"));
  ASSERT_EQ(positions.size(), 3 * rows.size());
  EXPECT_THAT(rows, Contains(1U));
  for (std::size_t k = 0; k < rows.size(); ++k) EXPECT_FLOAT_EQ(positions[3 * k + 1], 2.0F);
}

/// The page takes no grid of more than 16384 cells a side: a long corridor has few cells, but many in a row.
TEST(BuildScene, ALongGridIsCoarsenedUntilThePageTakesIt) {
  const Map map = planar_map(900.0);
  const auto fine = occupancy_grid_of(map);
  ASSERT_GT(fine->width, 16384);
  ASSERT_LT(static_cast<double>(fine->width) * fine->height, 16e6);
  const std::string bytes = bytes_of(map);
  const SceneBlock block(bytes);
  const auto& grid = *block.layer("grid");
  EXPECT_EQ(grid.at("width"), (fine->width + 1) / 2);
  EXPECT_EQ(grid.at("height"), (fine->height + 1) / 2);
  EXPECT_EQ(grid.at("cell"), 2.0 * fine->cell_m);
}

TEST(BuildScene, ShowsAllSubmapsOnRequest) {
  ViewSceneOptions all;
  all.submap = -1;
  const std::string bytes = bytes_of(planar_map(), all);
  EXPECT_EQ(SceneBlock(bytes).numbers<std::int32_t>(SceneBlock(bytes).header["keyframes"]["submaps"]),
            (std::vector<std::int32_t>{0, 0, 1}));
}

TEST(BuildScene, HasSemiDensePointsWithRowsAndSigmas) {
  Map map = make_landmark_test_map();
  auto layer = std::make_shared<SemiDenseLayer>();
  auto depth = std::make_shared<SemiDenseDepth>();
  depth->pixels.push_back({320, 240, 0.5F, 1e-6F, 77});
  layer->of[map.keyframes[2].id] = depth;
  map.layers.put<SemiDenseLayer>(std::move(layer));
  const std::string bytes = bytes_of(map);
  const SceneBlock block(bytes);
  const auto& json = *block.layer("semi_dense");
  EXPECT_EQ(block.numbers<std::uint32_t>(json.at("keyframes")), std::vector<std::uint32_t>{2});
  EXPECT_EQ(block.numbers<std::uint8_t>(json.at("colors")), (std::vector<std::uint8_t>{77, 77, 77}));
  EXPECT_FLOAT_EQ(block.numbers<float>(json.at("sigmas"))[0], 4e-3F) << "z^2 times the inverse depth's sigma";
  const Eigen::Vector2d ray((320 - 319.5) / 400.0, (240 - 239.5) / 400.0);
  const Eigen::Vector3d expected = map.keyframes[2].world_from_camera * Eigen::Vector3d(2 * ray.x(), 2 * ray.y(), 2.0);
  const auto position = block.numbers<float>(json.at("positions"));
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(position[static_cast<std::size_t>(axis)], expected[axis], 1e-5);
}

TEST(BuildScene, GivesTheSameBytesForAnyPool) {
  const Map map = make_test_map(4);
  ViewSceneOptions options;
  options.max_points = 2000, options.max_images = 4, options.octree = true;
  const std::string alone = bytes_of(map, options);
  EXPECT_EQ(bytes_of(map, options), alone);
  EXPECT_EQ(bytes_of(map, options, 3), alone);
}

TEST(BuildScene, TakesAnEmptyMap) {
  const std::string bytes = bytes_of(Map());
  const SceneBlock block(bytes);
  EXPECT_FALSE(block.header.contains("frames"));
  EXPECT_TRUE(block.header["layers"].empty());
}

}  // namespace
}  // namespace rastro
