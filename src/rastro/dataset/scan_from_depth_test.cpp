// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/scan_from_depth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/error.h"
#include "rastro/dataset/dataset_testing.h"

namespace rastro {
namespace {

using testing::HasSubstr;

Camera test_camera() {
  Camera camera;
  camera.width = 160;
  camera.height = 120;
  camera.fx = camera.fy = 140.0;
  camera.cx = 79.3;
  camera.cy = 60.2;
  return camera;
}

/// Depth of a plane: all points with normal * point = distance, in the camera frame.
DepthImage plane(const Camera& camera, const Eigen::Vector3d& normal, double distance) {
  DepthImage depth(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const auto ray = camera.unproject({x, y}).value();
      const double along = normal.dot(Eigen::Vector3d(ray.x(), ray.y(), 1.0));
      depth.at(x, y) = along > 1e-9 ? static_cast<float>(distance / along) : 0.0F;
    }
  }
  return depth;
}

/// The wall's exact distance along each beam of a scan at the height of the camera.
void expect_wall(const LaserScan& scan, const Eigen::Vector2d& normal, double distance, double tolerance) {
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    const double angle = scan.angle_of(beam);
    const double along = normal.dot(Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    ASSERT_TRUE(scan.is_return(beam)) << beam;
    // A pixel's direction is within half a step of its beam's.
    EXPECT_NEAR(scan.ranges[beam], distance / along, tolerance) << beam;
  }
}

TEST(ScanFromDepth, AWallIsSeenWhereItStandsInEveryBeam) {
  const Camera camera = test_camera();
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, 0.0, 1.0).normalized();  // Nearer on the right.
  const ScanFromDepth cutter(camera, {});
  const LaserScan scan = cutter.cut(plane(camera, normal, 2.0));
  EXPECT_NEAR(scan.first_angle, -std::atan((159.0 - 79.3) / 140.0), 0.5 / 140.0);
  EXPECT_NEAR(scan.angle_of(scan.ranges.size() - 1), std::atan(79.3 / 140.0), 0.5 / 140.0);
  // Laser frame: x forward is the camera's z, y left is its -x.
  expect_wall(scan, {normal.z(), -normal.x()}, 2.0, 0.012);
  EXPECT_LT(scan.ranges.front(), scan.ranges.back());
}

TEST(ScanFromDepth, ALensWithDistortionSeesTheSameWall) {
  Camera camera = test_camera();
  camera.distortion = Distortion::radial_tangential;
  camera.coefficients = {-0.2, 0.05, 0.001, -0.002, 0.0};
  const LaserScan scan = ScanFromDepth(camera, {}).cut(plane(camera, {0.0, 0.0, 1.0}, 3.0));
  std::size_t seen = 0;
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (!scan.is_return(beam)) continue;
    ++seen;
    EXPECT_NEAR(scan.ranges[beam] * std::cos(scan.angle_of(beam)), 3.0, 0.02) << beam;
  }
  // The corners look farther aside than the middle rows do, so some beams at the ends see nothing at this height.
  EXPECT_GT(seen, scan.ranges.size() * 9 / 10);
}

TEST(ScanFromDepth, OnlyTheBandOfHeightsCounts) {
  const Camera camera = test_camera();
  // The floor, 0.5 m below: in no band about the camera's height, in every beam of one about the floor.
  const DepthImage floor = plane(camera, {0.0, 1.0, 0.0}, 0.5);
  const LaserScan none = ScanFromDepth(camera, {}).cut(floor);
  for (std::size_t beam = 0; beam < none.ranges.size(); ++beam)
    EXPECT_FALSE(none.is_return(beam) || none.is_free(beam));
  ScanFromDepthOptions low;
  low.lowest = -0.6;
  low.highest = -0.4;
  const LaserScan some = ScanFromDepth(camera, low).cut(floor);
  // The lowest row meets the floor first.
  const double nearest = 0.5 * 140.0 / (119.0 - 60.2);
  EXPECT_NEAR(some.ranges[some.ranges.size() / 2], nearest, 0.01);
}

TEST(ScanFromDepth, FartherThanItsReachIsFree) {
  const Camera camera = test_camera();
  ScanFromDepthOptions options;
  options.max_range = 1.5;
  const LaserScan scan = ScanFromDepth(camera, options).cut(plane(camera, {0.0, 0.0, 1.0}, 2.0));
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) EXPECT_TRUE(scan.is_free(beam));
}

TEST(ScanFromDepth, RefusesWhatMakesNoSense) {
  ScanFromDepthOptions upside;
  upside.lowest = 1.0;
  EXPECT_THAT(error_of([&] { ScanFromDepth(test_camera(), upside); }), HasSubstr("not a range of heights"));
  EXPECT_THAT(error_of([&] { ScanFromDepth(Camera(), {}); }), HasSubstr("no focal length"));
}

}  // namespace
}  // namespace rastro
