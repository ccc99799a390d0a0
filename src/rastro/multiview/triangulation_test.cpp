// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/triangulation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "rastro/multiview/scene_testing.h"

namespace rastro {
namespace {

using testing::some_motion;
using testing::two_view_scene;

TEST(Triangulation, TwoViewsGiveThePointExactly) {
  Random random(1);
  const auto scene = two_view_scene(random, some_motion(), {.count = 100});
  for (std::size_t i = 0; i < scene.a.size(); ++i) {
    const auto point = triangulate(scene.second_from_first, scene.a[i], scene.b[i], {});
    ASSERT_TRUE(point);
    EXPECT_LT((point->position - scene.points[i]).norm(), 1e-8 * scene.points[i].squaredNorm());
    EXPECT_LT(point->error_px, 1e-9);
    const Eigen::Vector3d center = scene.second_from_first.inverse().translation();
    EXPECT_NEAR(point->parallax_deg,
                testing::angle_between(scene.points[i], scene.points[i] - center) * 180.0 / std::numbers::pi, 1e-7);
  }
}

TEST(Triangulation, ManyViewsAverageTheNoiseOut) {
  Random random(2);
  std::vector<SE3> world_from_camera;
  world_from_camera.reserve(8);
  for (int i = 0; i < 8; ++i) {
    world_from_camera.emplace_back(SO3::exp({0.0, -0.02 * i, 0.01 * i}), Eigen::Vector3d(5.0 + 0.3 * i, 1.0, 0.1 * i));
  }
  double two = 0.0, all = 0.0;
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3d ground_truth(5.0 + random.uniform(-2, 2), 1.0 + random.uniform(-1, 1), random.uniform(4, 12));
    std::vector<Eigen::Vector2d> exact, noisy;
    for (const SE3& pose : world_from_camera) {
      exact.push_back((pose.inverse() * ground_truth).hnormalized());
      noisy.push_back(exact.back() + 0.5 / 500.0 * Eigen::Vector2d(random.normal(), random.normal()));
    }
    const auto sharp = triangulate(world_from_camera, exact, {});
    ASSERT_TRUE(sharp);
    EXPECT_LT((sharp->position - ground_truth).norm(), 1e-8);
    const TriangulationOptions loose{.max_error_px = 10.0};
    const auto few = triangulate(std::span(world_from_camera).first(2), std::span(noisy).first(2), loose);
    const auto many = triangulate(world_from_camera, noisy, loose);
    ASSERT_TRUE(many);
    if (few) two += (few->position - ground_truth).norm();
    all += (many->position - ground_truth).norm();
  }
  EXPECT_LT(all, two / 5.0);
  EXPECT_LT(all / 200.0, 0.1);
}

TEST(Triangulation, RefinementLowersTheReprojectionErrorToItsMinimum) {
  Random random(3);
  const auto scene = two_view_scene(random, some_motion(), {.count = 50, .noise_px = 1.0});
  for (std::size_t i = 0; i < scene.a.size(); ++i) {
    const auto point = triangulate(scene.second_from_first, scene.a[i], scene.b[i], {.max_error_px = 20.0});
    if (!point || point->parallax_deg < 1.0) continue;
    const auto cost = [&](const Eigen::Vector3d& p) {
      return (scene.a[i] - p.hnormalized()).squaredNorm() +
             (scene.b[i] - (scene.second_from_first * p).hnormalized()).squaredNorm();
    };
    for (int axis = 0; axis < 3; ++axis) {
      for (const double step : {-1e-3, 1e-3}) {
        EXPECT_GE(cost(point->position + step * Eigen::Vector3d::Unit(axis)), cost(point->position) - 1e-12);
      }
    }
  }
}

TEST(Triangulation, RefusesRaysWithoutAPoint) {
  const SE3 sideways(SO3(), {-1.0, 0.0, 0.0});
  EXPECT_FALSE(triangulate(sideways, {0.1, 0.1}, {0.1, 0.1}, {}));   // parallel rays
  EXPECT_FALSE(triangulate(sideways, {0.0, 0.0}, {0.2, 0.0}, {}));   // meet behind the cameras
  EXPECT_FALSE(triangulate(sideways, {0.0, 0.0}, {-0.2, 0.1}, {}));  // pass each other too far
  EXPECT_FALSE(triangulate(SE3(), {0.0, 0.0}, {0.0, 0.0}, {}));      // one position
  EXPECT_TRUE(triangulate(sideways, {0.0, 0.0}, {-0.01, 0.0}, {}));  // 100 m
  EXPECT_FALSE(triangulate(sideways, {0.0, 0.0}, {-0.01, 0.0}, {.min_parallax_deg = 1.0}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(triangulate(sideways, {nan, 0.0}, {-0.01, 0.0}, {}));
  const std::vector<SE3> one(1);
  const std::vector<Eigen::Vector2d> point(1, Eigen::Vector2d::Zero());
  EXPECT_FALSE(triangulate(one, point, {}));
}

}  // namespace
}  // namespace rastro
