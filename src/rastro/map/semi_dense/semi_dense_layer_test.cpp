// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/semi_dense/semi_dense_layer.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>

#include "rastro/map/graph/map.h"
#include "rastro/map/layer_type.h"

namespace rastro {
namespace {

std::shared_ptr<const SemiDenseDepth> row_of(std::uint16_t pixels) {
  auto depth = std::make_shared<SemiDenseDepth>();
  for (std::uint16_t x = 0; x < pixels; ++x) depth->pixels.push_back({x, 0, 0.5F, 1e-4F, 77});
  return depth;
}

TEST(SemiDenseLayer, PixelsOfOtherSubmapsDoNotThinThoseThatAreShown) {
  Map map;
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 400.0, camera.cx = 319.5, camera.cy = 239.5;
  map.cameras.push_back({CameraKind::mono, camera, 0.0, {}, SE3()});
  map.keyframes.push_back({0, 0, 0, 0, SE3(), 0, no_keyframe, 1.0});
  map.keyframes.push_back({1, 1, 1, 0, SE3(), 1, no_keyframe, 1.0});
  SemiDenseLayer layer;
  layer.of[0] = row_of(10);
  layer.of[1] = row_of(600);
  const auto points_of = [&](int submap) {
    PointCloud cloud;
    semi_dense_layer_type()->add_points(map, layer, submap, 10, cloud);
    return cloud.points.size();
  };
  EXPECT_EQ(points_of(0), 10U);
  EXPECT_EQ(points_of(1), 10U);
  EXPECT_LE(points_of(-1), 11U);
}

}  // namespace
}  // namespace rastro
