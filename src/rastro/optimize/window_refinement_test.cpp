// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/window_refinement.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "rastro/base/random.h"

namespace rastro {
namespace {

/// Five cameras along a line and fifty points in front of them, each observed by all.
RefinementWindow exact_window() {
  Random random(3);
  RefinementWindow window;
  for (int camera = 0; camera < 5; ++camera) {
    const SE3 world_from_camera(SO3::exp({0.01 * camera, 0.03 * camera, -0.02 * camera}),
                                {0.4 * camera, 0.05 * camera, 0.3 * camera});
    window.camera_from_world.push_back(world_from_camera.inverse());
    window.fixed.push_back(camera < 2 ? 1 : 0);
  }
  for (int point = 0; point < 50; ++point) {
    window.points.emplace_back(6.0 * random.uniform() - 3.0, 4.0 * random.uniform() - 2.0,
                               5.0 + 6.0 * random.uniform());
    for (int camera = 0; camera < 5; ++camera) {
      const Eigen::Vector3d there = window.camera_from_world[static_cast<std::size_t>(camera)] * window.points.back();
      window.observations.push_back({camera, point, there.head<2>() / there.z()});
    }
  }
  return window;
}

RefinementWindow disturbed(const RefinementWindow& exact) {
  Random random(4);
  RefinementWindow window = exact;
  for (std::size_t i = 2; i < window.camera_from_world.size(); ++i) {
    const SE3& pose = window.camera_from_world[i];
    const auto small = [&](double size) -> Eigen::Vector3d {
      return size * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    };
    window.camera_from_world[i] = SE3(SO3::exp(small(0.01)) * pose.rotation(), pose.translation() + small(0.05));
  }
  for (Eigen::Vector3d& point : window.points)
    point += 0.1 * Eigen::Vector3d(random.normal(), random.normal(), 2.0 * random.normal());
  return window;
}

TEST(RefineWindow, RecoversTheExactPosesAndPoints) {
  const RefinementWindow exact = exact_window();
  RefinementWindow window = disturbed(exact);
  EXPECT_LT(refine_window(window, {30, 1e3}), 1e-4);
  for (std::size_t i = 0; i < exact.camera_from_world.size(); ++i) {
    const SE3 difference = window.camera_from_world[i] * exact.camera_from_world[i].inverse();
    EXPECT_LT(difference.translation().norm(), 1e-5);
    EXPECT_LT(difference.rotation().log().norm(), 1e-6);
  }
}

TEST(RefineWindow, FixedCamerasStayAndWrongMatchesHaveLittleEffect) {
  const RefinementWindow exact = exact_window();
  RefinementWindow window = disturbed(exact);
  for (std::size_t i = 0; i < window.observations.size(); i += 17)
    window.observations[i].ray += Eigen::Vector2d(0.08, -0.05);
  RefinementWindow plain = window;
  refine_window(window, {30, 1.0});
  refine_window(plain, {30, 1e3});
  EXPECT_EQ(window.camera_from_world[0].matrix(), exact.camera_from_world[0].matrix());
  EXPECT_EQ(window.camera_from_world[1].matrix(), exact.camera_from_world[1].matrix());
  const auto error = [&](const RefinementWindow& adjusted) {
    return (adjusted.camera_from_world[4] * exact.camera_from_world[4].inverse()).translation().norm();
  };
  EXPECT_LT(error(window), 0.5 * error(plain));
}

TEST(RefineWindow, NoFreeCameraOrNoObservationIsNoError) {
  RefinementWindow window = exact_window();
  window.fixed.assign(5, 1);
  EXPECT_LT(refine_window(window, {}), 1e-6);
  RefinementWindow empty;
  EXPECT_EQ(refine_window(empty, {}), 0.0);
  window.fixed = {1, 1, 0, 0, 0};
  for (Eigen::Vector3d& point : window.points) point.z() = -5.0;
  refine_window(window, {});
  for (const SE3& pose : window.camera_from_world) EXPECT_TRUE(pose.matrix().allFinite());
}

}  // namespace
}  // namespace rastro
