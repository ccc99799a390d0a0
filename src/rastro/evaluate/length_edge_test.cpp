// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/length_edge.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rastro {
namespace {

constexpr double edge_x_px = 1003.3;

/// A flat face seen from the front in an HD image; along the image's rows it becomes brighter at `edge_x_px`.
LengthView hd_view() {
  LengthView view;
  view.camera.width = 1920, view.camera.height = 1080;
  view.camera.fx = view.camera.fy = 1400.0, view.camera.cx = 959.5, view.camera.cy = 539.5;
  view.gray = GrayImage(1920, 1080);
  for (int y = 0; y < 1080; ++y)
    for (int x = 0; x < 1920; ++x)
      view.gray.at(x, y) = static_cast<std::uint8_t>(std::lround(100.0 + 30.0 * std::erf(x - edge_x_px)));
  return view;
}

LengthFace face_at(double depth_m) {
  LengthFace face;
  face.inverse = {0.0, 0.0, 1.0 / depth_m};
  return face;
}

/// 10 px beside the edge.
LengthEdgeSearch search_at(const LengthView& view, double depth_m, double radius_m) {
  LengthEdgeSearch search;
  search.spot = {(edge_x_px + 10.0 - view.camera.cx) / view.camera.fx * depth_m, 0.0, depth_m};
  search.direction = Eigen::Vector3d::UnitY();
  search.inwards = Eigen::Vector3d::UnitX();
  search.radius_m = radius_m;
  return search;
}

/// The search radius of 6 cm is 84 pixels at 1 m, 210 at 0.4 m and 420 at 0.2 m.
TEST(LengthEdge, IsFoundHoweverNearTheCameraIs) {
  const LengthView view = hd_view();
  for (const double depth_m : {1.0, 0.4, 0.2}) {
    const auto edges = find_edges(view, face_at(depth_m), search_at(view, depth_m, 0.06));
    ASSERT_FALSE(edges.empty()) << depth_m;
    const double x_px = view.camera.fx * edges.front().point.x() / depth_m + view.camera.cx;
    EXPECT_NEAR(x_px, edge_x_px, 0.2) << depth_m;
    EXPECT_NEAR(edges.front().pixel_m, depth_m / view.camera.fx, 1e-6) << depth_m;
    const double sigma_px = std::sqrt(edges.front().covariance(0, 0)) / edges.front().pixel_m;
    EXPECT_GT(sigma_px, 0.1) << depth_m;
    EXPECT_LT(sigma_px, 0.5) << depth_m;
  }
}

TEST(LengthEdge, IsNotSearchedForInMoreThanTheImage) {
  const LengthView view = hd_view();
  EXPECT_TRUE(find_edges(view, face_at(0.2), search_at(view, 0.2, 0.5)).empty());
}

}  // namespace
}  // namespace rastro
