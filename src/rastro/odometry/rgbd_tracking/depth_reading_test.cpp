// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/depth_reading.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "rastro/base/random.h"
#include "rastro/odometry/rgbd_tracking/point_map.h"
#include "rastro/odometry/rgbd_tracking/room_testing.h"

namespace rastro {
namespace {

constexpr int width = 320, height = 240;

Camera camera() { return PaperedRoom().camera; }

/// Depth of the plane normal . p = distance in a camera at the origin.
DepthImage plane(const Eigen::Vector3d& normal, double distance) {
  DepthImage depth(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector3d ray((x - camera().cx) / camera().fx, (y - camera().cy) / camera().fy, 1.0);
      depth.at(x, y) = static_cast<float>(distance / normal.dot(ray));
    }
  }
  return depth;
}

Eigen::Vector2d ray_of(double x, double y) { return *camera().unproject(Eigen::Vector2d(x, y)); }

TEST(ReadDepth, OfASlantedPlaneIsExactBetweenPixelsToo) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.2, -0.15, 1.0).normalized();
  const DepthImage depth = plane(normal, 2.0);
  for (const auto& [x, y] : {std::pair{100.0, 80.0}, {100.4, 80.3}, {201.5, 160.5}, {30.25, 199.75}}) {
    const auto reading = read_depth(depth, camera(), ray_of(x, y), SE3(), {});
    ASSERT_TRUE(reading) << x;
    const Eigen::Vector3d ray = ray_of(x, y).homogeneous();
    EXPECT_NEAR(reading->inverse_depth, normal.dot(ray) / 2.0, 1e-6) << x;
    EXPECT_EQ(reading->per_second, 0.0);
  }
}

/// The depth camera has another pose: its reading is transformed into the color camera.
TEST(ReadDepth, FollowsTheMotionBetweenColorAndDepth) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.1, 0.1, 1.0).normalized();
  const DepthImage depth = plane(normal, 2.5);
  const SE3 depth_from_color(SO3::exp({0.01, -0.02, 0.005}), {0.03, -0.01, 0.04});
  // The plane in the color camera: n . (R p + t) = d.
  const Eigen::Vector3d in_color = depth_from_color.rotation().inverse() * normal;
  const double distance = 2.5 - normal.dot(depth_from_color.translation());
  for (const auto& [x, y] : {std::pair{90.0, 70.0}, {160.0, 120.0}, {250.5, 180.5}}) {
    const auto reading = read_depth(depth, camera(), ray_of(x, y), depth_from_color, {});
    ASSERT_TRUE(reading);
    const Eigen::Vector3d ray = ray_of(x, y).homogeneous();
    EXPECT_NEAR(reading->inverse_depth, in_color.dot(ray) / distance, 2e-4) << x;
  }
}

TEST(ReadDepth, NoiseIsAveragedAndStaysWithinItsSigma) {
  const RgbdOptions options;
  Random random(3);
  double squares = 0.0;
  constexpr int count = 300;
  for (int k = 0; k < count; ++k) {
    DepthImage depth(width, height);
    for (int y = 100; y < 140; ++y) {
      for (int x = 140; x < 180; ++x) {
        const double inverse = 0.5 + inverse_depth_sigma(options, 0.5) * random.normal();
        depth.at(x, y) = static_cast<float>(1.0 / inverse);
      }
    }
    const auto reading = read_depth(depth, camera(), ray_of(160.0, 120.0), SE3(), options);
    ASSERT_TRUE(reading);
    EXPECT_NEAR(reading->sigma, inverse_depth_sigma(options, 0.5), 0.01 * reading->sigma);
    squares += std::pow((reading->inverse_depth - 0.5) / reading->sigma, 2);
  }
  const double rms = std::sqrt(squares / count);
  EXPECT_LT(rms, 0.5) << "of 25 pixels, whose errors are independent here";
  EXPECT_GT(rms, 0.1);
}

TEST(ReadDepth, SigmaIsThatOfTheNoiseInInverseDepth) {
  RgbdOptions options;
  options.depth_sigma_m = 0.004;
  options.depth_sigma_per_m2 = 0.003;
  for (const double z : {0.5, 1.0, 3.0}) {
    const double sigma_z = options.depth_sigma_m + options.depth_sigma_per_m2 * z * z;
    EXPECT_NEAR(inverse_depth_sigma(options, 1.0 / z), sigma_z / (z * z), 1e-12) << "d(1/z) = dz / z^2";
  }
}

TEST(ReadDepth, HasNoneAtAnEdgeOfDepth) {
  DepthImage depth = plane({0.0, 0.0, 1.0}, 2.0);
  for (int y = 0; y < height; ++y)
    for (int x = 200; x < width; ++x) depth.at(x, y) = 3.0F;
  for (int x = 198; x <= 201; ++x) EXPECT_FALSE(read_depth(depth, camera(), ray_of(x, 120.0), SE3(), {})) << x;
  for (const int x : {190, 197, 203, 210}) EXPECT_TRUE(read_depth(depth, camera(), ray_of(x, 120.0), SE3(), {})) << x;
}

/// A wire in front of a wall: the same depth on both sides, and yet two surfaces.
TEST(ReadDepth, HasNoneAcrossAThinObject) {
  for (const float thin_m : {1.9F, 1.5F}) {
    DepthImage depth = plane({0.0, 0.0, 1.0}, 2.0);
    for (int y = 0; y < height; ++y) depth.at(160, y) = thin_m;
    EXPECT_FALSE(read_depth(depth, camera(), ray_of(160.0, 120.0), SE3(), {})) << thin_m;
  }
}

TEST(ReadDepth, HasNoneWithTooFewMeasurements) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const float missing : {0.0F, nan, 0.1F, 20.0F}) {  // the last two are out of range
    for (const int holes : {10, 11}) {
      DepthImage depth = plane({0.0, 0.0, 1.0}, 2.0);
      int left = holes;
      for (int y = 118; y <= 122; ++y)
        for (int x = 158; x <= 162 && left > 0; ++x, --left) depth.at(x, y) = missing;
      EXPECT_EQ(read_depth(depth, camera(), ray_of(160.0, 120.0), SE3(), {}).has_value(), holes == 10) << missing;
    }
  }
  const DepthImage depth = plane({0.0, 0.0, 1.0}, 2.0);
  for (const double x : {0.0, 1.4, 317.6, 319.0})
    EXPECT_FALSE(read_depth(depth, camera(), ray_of(x, 120.0), SE3(), {})) << x << ": at the rim";
  EXPECT_FALSE(read_depth(depth, camera(), {5.0, 0.0}, SE3(), {})) << "outside the image";
  EXPECT_FALSE(read_depth(DepthImage(), camera(), ray_of(160.0, 120.0), SE3(), {}));
}

TEST(ReadDepth, HasNoneOnASurfaceSeenEdgeOn) {
  const DepthImage steep = plane(Eigen::Vector3d(1.0, 0.0, 0.05).normalized(), 0.2);
  EXPECT_FALSE(read_depth(steep, camera(), ray_of(200.0, 120.0), SE3(), {}));
}

/// Means of readings, discarded old references, and a delay estimated later.
TEST(PointMap, AReadingMovesTheMeanAndManyHaveNoMoreInformationThanFour) {
  MapPoint point;
  const std::vector<double> values{0.5, 0.54, 0.46, 0.52, 0.48, 0.5};
  double sum = 0.0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    PointMap::add_reading(point, {values[k], 0.01, 2.0 * values[k]});
    sum += values[k];
    EXPECT_NEAR(point.inverse_depth, sum / static_cast<double>(k + 1), 1e-12);
    EXPECT_NEAR(point.per_second, 2.0 * point.inverse_depth, 1e-12);
    EXPECT_NEAR(point.information, std::min<double>(static_cast<double>(k + 1), 4.0) / 1e-4, 1e-6);
  }
}

PointMap map_of(int references) {
  PointMap map;
  for (int k = 0; k < references; ++k) {
    Reference reference;
    reference.world_from_camera = SE3(SO3(), {1.0 * k, 0.0, 0.0});
    reference.planes.resize(3);
    reference.velocity[0] = 0.5;
    map.references.push_back(reference);
    MapPoint point;
    point.anchor = k;
    point.ray = {0.1, 0.2};
    point.inverse_depth = 0.5;
    point.per_second = 0.1;
    map.points.push_back(point);
  }
  return map;
}

TEST(PointMap, APointFollowsItsReference) {
  const PointMap map = map_of(3);
  EXPECT_LT((map.in_world(map.points[2]) - Eigen::Vector3d(2.2, 0.4, 2.0)).norm(), 1e-12);
}

TEST(PointMap, OldReferencesLosePlanesAndPointsAndKeepTheirPoses) {
  PointMap map = map_of(6);
  map.points[5].missed = 4;
  map.forget(3, 3);
  EXPECT_EQ(map.references.size(), 6U) << "poses are kept";
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(map.references[k].planes.empty(), k < 3) << k;
  ASSERT_EQ(map.points.size(), 2U);
  EXPECT_EQ(map.points[0].anchor, 3);
  EXPECT_EQ(map.points[1].anchor, 4) << "the one missed too often is gone";
  map.first_live = 5;
  map.forget(3, 3);
  EXPECT_TRUE(map.points.empty()) << "of a discarded map";
}

TEST(PointMap, ADelayChangesDepthsAndThePosesAtWhichTheyWereTaken) {
  PointMap map = map_of(3);
  map.references[0].planes.clear();
  map.first_live = 0;
  map.points[2].per_second = -100.0;
  map.delay_depths(0.02);
  EXPECT_NEAR(map.points[0].inverse_depth, 0.502, 1e-12);
  EXPECT_NEAR(map.points[2].inverse_depth, 0.5, 1e-12) << "never behind the camera";
  EXPECT_EQ(map.references[0].camera_from_depth.translation().x(), 0.0) << "has no surfaces any more";
  EXPECT_NEAR(map.references[1].camera_from_depth.translation().x(), 0.01, 1e-12);
}

}  // namespace
}  // namespace rastro
