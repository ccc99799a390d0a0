// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/projective_icp.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

namespace rastro {
namespace {

Camera small_camera() {
  Camera camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = 260.0;
  camera.cx = 159.5;
  camera.cy = 119.5;
  return camera;
}

/// Exact depth of the inside of planes n . p = d of the world.
DepthImage depth_of(const std::vector<Eigen::Vector4d>& planes, const SE3& world_from_camera) {
  const Camera camera = small_camera();
  DepthImage depth(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d ray =
          world_from_camera.rotation() * Eigen::Vector3d((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1.0);
      double nearest = 1e9;
      for (const Eigen::Vector4d& plane : planes) {
        const double along = plane.head<3>().dot(ray);
        if (along > 1e-9)
          nearest = std::min(nearest, (plane(3) - plane.head<3>().dot(world_from_camera.translation())) / along);
      }
      depth.at(x, y) = static_cast<float>(nearest);
    }
  }
  return depth;
}

const std::vector<Eigen::Vector4d> corner = {{0.6, 0, 0.8, 2}, {-0.8, 0, 0.6, 2}, {0, 0.8, 0.6, 2}};

SE3 small_motion() {
  Vector6d motion;
  motion << 0.02, -0.01, 0.015, 0.01, -0.008, 0.012;
  return SE3::exp(motion);
}

TEST(ProjectiveIcp, FindsAKnownMotionInACorner) {
  const ProjectiveIcp icp(small_camera(), {});
  const auto reference = icp.planes(depth_blocks(depth_of(corner, SE3()), {}, {}));
  const DepthBlocks blocks = depth_blocks(depth_of(corner, small_motion()), {}, {});
  SE3 pose;
  for (int i = 0; i < 15; ++i) {
    const SurfaceFit fit = icp.compare(reference, blocks, pose, 0.1, 1);
    pose = pose * SE3::exp(fit.information.ldlt().solve(fit.gradient));
  }
  const Vector6d off = (small_motion().inverse() * pose).log();
  // Not exact: planes along the creases are fitted across them.
  EXPECT_LT(off.head<3>().norm(), 0.003);
  EXPECT_LT(off.tail<3>().norm(), 0.001);
  const SurfaceFit fit = icp.compare(reference, blocks, pose, 0.1, 1);
  EXPECT_GT(fit.compared, 1500);
  EXPECT_GT(fit.fitting, 0.95 * fit.compared);
}

TEST(ProjectiveIcp, OnePlaneConstrainsThreeDirectionsOnly) {
  const ProjectiveIcp icp(small_camera(), {});
  const std::vector<Eigen::Vector4d> wall = {{0, 0, 1, 2}};
  const DepthBlocks blocks = depth_blocks(depth_of(wall, SE3()), {}, {});
  const SurfaceFit fit = icp.compare(icp.planes(blocks), blocks, SE3(), 0.1, 1);
  const Vector6d values = Eigen::SelfAdjointEigenSolver<Matrix6d>(fit.information).eigenvalues();
  EXPECT_LT(values(2), 1e-4 * values(3));
}

TEST(ProjectiveIcp, PlanesAreThoseOfTheSceneButAlongCreases) {
  const ProjectiveIcp icp(small_camera(), {});
  const auto planes = icp.planes(depth_blocks(depth_of(corner, SE3()), {}, {}));
  int found = 0, right = 0;
  for (const BlockPlane& plane : planes) {
    if (!(plane.distance > 0.0F)) continue;
    ++found;
    double nearest = 1.0;
    for (const Eigen::Vector4d& ground_truth : corner)
      nearest = std::min(nearest, (ground_truth.head<3>() - plane.normal.cast<double>()).norm());
    if (nearest < 0.01) ++right;
  }
  EXPECT_GT(found, 3000);
  EXPECT_GT(right, 0.85 * found);
}

TEST(ProjectiveIcp, BlocksAcrossEdgesHolesAndMasksAreLeftOut) {
  DepthImage depth(16, 8);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 16; ++x) depth.at(x, y) = x < 6 ? 1.0F : 2.0F;
  }
  for (int x = 8; x < 12; ++x) depth.at(x, 0) = depth.at(x, 1) = 0.0F;
  GrayImage mask(16, 8);
  for (int y = 0; y < 8; ++y) std::fill_n(mask.row(y), 16, std::uint8_t{1});
  mask.at(13, 6) = 0;
  const DepthBlocks blocks = depth_blocks(depth, mask.view(), {});
  const std::vector<float> expected = {1, 0, 0, 2, 1, 0, 2, 0};
  EXPECT_EQ(blocks.depth, expected);
}

}  // namespace
}  // namespace rastro
