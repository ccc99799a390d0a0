// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/landmarks/landmark_uncertainty.h"

#include <gtest/gtest.h>

#include <limits>

#include "rastro/map/landmarks/landmark_map_testing.h"
#include "rastro/map/layer_type.h"

namespace rastro {
namespace {

/// A map in which every landmark has only its first observation.
Map seen_once(CameraKind sensor) {
  TestRoad road;
  road.sensor = sensor;
  Map map = make_landmark_test_map(road);
  auto landmarks = std::make_shared<LandmarkLayer>(*map.layer<LandmarkLayer>());
  for (Landmark& landmark : landmarks->landmarks) landmark.observations.resize(1);
  map.layers.put<LandmarkLayer>(landmarks);
  return map;
}

double depth_in_first(const Map& map, const Landmark& landmark) {
  return (map.find(landmark.observations.front().keyframe)->world_from_camera.inverse() * landmark.position).z();
}

/// Standard deviation along the optical axis.
double depth_sigma(const Map& map, const Landmark& landmark, const Eigen::Matrix3d& covariance) {
  const SE3& pose = map.find(landmark.observations.front().keyframe)->world_from_camera;
  const Eigen::Vector3d axis = pose.rotation() * Eigen::Vector3d::UnitZ();
  return std::sqrt(axis.dot(covariance * axis));
}

TEST(LandmarkUncertainty, OneObservationOfOneCameraDoesNotDetermineTheDistance) {
  const Map map = seen_once(CameraKind::mono);
  for (const Landmark& landmark : map.layer<LandmarkLayer>()->landmarks)
    EXPECT_FALSE(landmark_covariance(map, landmark));
}

TEST(LandmarkUncertainty, ADisparityDeterminesTheDistance) {
  const Map map = seen_once(CameraKind::stereo);
  const std::vector<double> scales = orb_level_scales(map.layer<FeatureLayer>()->extraction);
  for (const Landmark& landmark : map.layer<LandmarkLayer>()->landmarks) {
    const LandmarkObservation& only = landmark.observations.front();
    const ImageFeatures& image = *map.layer<FeatureLayer>()->find(only.keyframe);
    const double scale = scales[image.features.levels[only.feature]];
    const auto covariance = landmark_covariance(map, landmark);
    ASSERT_EQ(covariance.has_value(), image.right_x[only.feature] >= 0.0F) << "whether the right camera sees it";
    if (!covariance) continue;
    const double z = depth_in_first(map, landmark);
    const double expected = scale * z * z / (TestRoad::camera().fx * TestRoad::baseline_m);
    EXPECT_NEAR(depth_sigma(map, landmark, *covariance), expected, 1e-6 * expected);
  }
}

TEST(LandmarkUncertainty, AMeasuredDepthDeterminesTheDistance) {
  const Map map = seen_once(CameraKind::depth);
  const Landmark& landmark = map.layer<LandmarkLayer>()->landmarks[3];
  const auto covariance = landmark_covariance(map, landmark);
  ASSERT_TRUE(covariance);
  const double expected = map.cameras[0].depth_noise.sigma(depth_in_first(map, landmark));
  EXPECT_NEAR(depth_sigma(map, landmark, *covariance), expected, 1e-4 * expected);
}

TEST(LandmarkUncertainty, FarBeyondTheBaselineTheDistanceIsUnknown) {
  Map map = seen_once(CameraKind::stereo);
  auto landmarks = std::make_shared<LandmarkLayer>(*map.layer<LandmarkLayer>());
  Landmark& landmark = landmarks->landmarks[0];
  const SE3& pose = map.find(landmark.observations.front().keyframe)->world_from_camera;
  landmark.position = pose * (3e5 * (pose.inverse() * landmark.position));
  map.layers.put<LandmarkLayer>(landmarks);
  EXPECT_FALSE(landmark_covariance(map, landmarks->landmarks[0]));
  EXPECT_EQ(layer_points(map, -1).points[0].sigma, 0.0F) << "which files say as nan";
}

}  // namespace
}  // namespace rastro
