// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/landmarks/landmark_layer.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <map>
#include <set>

#include "rastro/base/error.h"
#include "rastro/map/graph/covisibility.h"
#include "rastro/map/landmarks/landmark_map_testing.h"
#include "rastro/map/landmarks/landmark_uncertainty.h"
#include "rastro/map/landmarks/map_scale.h"

namespace rastro {
namespace {

const std::vector<Landmark>& landmarks_of(const Map& map) { return map.layer<LandmarkLayer>()->landmarks; }

Map road_in_units(double unit, CameraKind sensor = CameraKind::mono) {
  TestRoad road;
  road.unit = unit, road.sensor = sensor, road.keyframes = 24, road.landmarks = 900;
  return make_landmark_test_map(road);
}

std::size_t shared_by(const Map& map, std::int64_t a, std::int64_t b) {
  const auto sees = [](const Landmark& landmark, std::int64_t keyframe) {
    return std::any_of(landmark.observations.begin(), landmark.observations.end(),
                       [&](const auto& observation) { return observation.keyframe == keyframe; });
  };
  return static_cast<std::size_t>(std::count_if(landmarks_of(map).begin(), landmarks_of(map).end(),
                                                [&](const Landmark& each) { return sees(each, a) && sees(each, b); }));
}

TEST(CovisibilityGraph, EqualsCountingPairByPair) {
  const Map map = make_landmark_test_map();
  const auto graph = covisibility_graph(map, 15);
  std::size_t next = 0;
  for (std::uint32_t a = 0; a < map.keyframes.size(); ++a) {
    for (std::uint32_t b = a + 1; b < map.keyframes.size(); ++b) {
      const std::size_t shared = shared_by(map, map.keyframes[a].id, map.keyframes[b].id);
      if (shared < 15) continue;
      ASSERT_LT(next, graph.size());
      EXPECT_EQ(graph[next].first, a);
      EXPECT_EQ(graph[next].second, b);
      EXPECT_EQ(graph[next++].shared, static_cast<int>(shared));
    }
  }
  EXPECT_EQ(next, graph.size());
  EXPECT_GT(next, 10U);
}

TEST(EssentialGraph, HasTheTreeTheLoopClosureAndStrongCovisibility) {
  const Map map = make_landmark_test_map();
  const int strong = covisibility_graph(map, 1).size() > 12 ? 60 : 1;
  const auto graph = essential_graph(map, strong);
  std::map<EssentialKind, int> kinds;
  std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const EssentialEdge& edge : graph) {
    ++kinds[edge.kind];
    EXPECT_LT(edge.first, edge.second);
    EXPECT_TRUE(pairs.emplace(edge.first, edge.second).second) << "each pair once";
    if (edge.kind == EssentialKind::covisible) {
      EXPECT_GE(edge.shared, strong);
    }
  }
  EXPECT_EQ(kinds[EssentialKind::constraint], 1);
  EXPECT_EQ(kinds[EssentialKind::tree], 11);
  for (const Covisibility& pair : covisibility_graph(map, strong))
    EXPECT_TRUE(pairs.contains({pair.first, pair.second}));
}

TEST(MapScale, OfKnownLengthsIsExactOnAnExactMap) {
  const Map map = road_in_units(0.37);
  const auto meters = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return (a - b).norm() / 0.37; };
  const Landmark &a = landmarks_of(map)[5], &b = landmarks_of(map)[200];
  const KnownLength between_landmarks{a.id, b.id, false, meters(a.position, b.position)};
  const MapScaleFound one = scale_from_lengths(map, std::array{between_landmarks}, "here");
  EXPECT_NEAR(one.meters_per_unit, 1.0 / 0.37, 1e-9);
  EXPECT_GT(one.relative_sigma, 0.0) << "the positions of landmarks are known so well and no better";
  EXPECT_LT(one.relative_sigma, 0.1);
  const Trajectory trajectory = trajectory_of(map);
  const KnownLength between_frames{
      7, 33, true, meters(trajectory[7].world_from_body.translation(), trajectory[33].world_from_body.translation())};
  const MapScaleFound frames = scale_from_lengths(map, std::array{between_frames}, "here");
  EXPECT_NEAR(frames.meters_per_unit, 1.0 / 0.37, 1e-6);
  KnownLength wrong = between_landmarks;
  wrong.meters *= 1.1;
  const MapScaleFound two = scale_from_lengths(map, std::array{between_frames, wrong}, "here");
  EXPECT_GT(two.relative_sigma, 0.005);
  EXPECT_THROW(scale_from_lengths(map, std::array{KnownLength{10, 11, false, 1.0}}, "here"), Error) << "10 was culled";
  EXPECT_THROW(scale_from_lengths(map, std::array{KnownLength{0, 4000, true, 1.0}}, "here"), Error);
  EXPECT_THROW(scale_from_lengths(map, std::array{KnownLength{a.id, a.id, false, 1.0}}, "here"), Error);
}

TEST(MapScale, OfAReferenceInAnotherFrameIsFoundWithItsSigma) {
  const Map map = road_in_units(0.37);
  const SE3 other(SO3::exp({0.1, 2.0, -0.4}), {100.0, -20.0, 3.0});
  Trajectory reference;
  Random random(3);
  for (const StampedPose& pose : trajectory_of(map)) {
    Eigen::Vector3d position = other * Eigen::Vector3d(pose.world_from_body.translation() / 0.37);
    for (double& value : position) value += 0.05 * random.normal();
    reference.push_back({pose.stamp, SE3(SO3(), position)});
  }
  const MapScaleFound found = scale_from_reference(map, reference, "here");
  EXPECT_NEAR(found.meters_per_unit * 0.37, 1.0, 4.0 * found.relative_sigma);
  EXPECT_LT(found.relative_sigma, 0.005);
  EXPECT_GT(found.relative_sigma, 1e-5);
  for (StampedPose& pose : reference) pose.stamp += 1'000'000'000'000;
  EXPECT_THROW(scale_from_reference(map, reference, "here"), Error) << "another clock";
}

TEST(MapScale, FromACameraHeightUsesTheGroundAhead) {
  const Map map = road_in_units(0.37);
  const MapScaleFound found = scale_from_camera_height(map, TestRoad::camera_height_m, "here");
  EXPECT_NEAR(found.meters_per_unit * 0.37, 1.0, 0.02);
  EXPECT_LT(found.relative_sigma, 0.02);
  Map without_ground = map;
  auto layer = std::make_shared<LandmarkLayer>(*map.layer<LandmarkLayer>());
  for (Landmark& landmark : layer->landmarks) landmark.position.y() = -std::abs(landmark.position.y()) - 1.0;
  without_ground.layers.put<LandmarkLayer>(std::move(layer));
  EXPECT_THROW(scale_from_camera_height(without_ground, 1.65, "here"), Error);
}

TEST(MapScale, AScaledMapIsTheOneMadeInMeters) {
  const Map meters = road_in_units(1.0);
  MapScaleFound found;
  found.meters_per_unit = 1.0 / 0.37;
  found.relative_sigma = 0.01;
  found.from = "a known length";
  const Map map = scaled(road_in_units(0.37), found);
  EXPECT_TRUE(scale_of(map).metric);
  EXPECT_EQ(scale_of(map).relative_sigma, 0.01);
  EXPECT_EQ(scale_of(map).origin, "a known length");
  const auto distance = [](const SE3& a, const SE3& b) { return (a.translation() - b.translation()).norm(); };
  for (std::size_t k = 0; k < map.keyframes.size(); ++k)
    EXPECT_LT(distance(map.keyframes[k].world_from_camera, meters.keyframes[k].world_from_camera), 1e-12);
  ASSERT_EQ(landmarks_of(map).size(), landmarks_of(meters).size());
  for (std::size_t i = 0; i < landmarks_of(map).size(); ++i) {
    EXPECT_LT((landmarks_of(map)[i].position - landmarks_of(meters)[i].position).norm(), 1e-12);
    EXPECT_NEAR(landmarks_of(map)[i].max_distance, landmarks_of(meters)[i].max_distance, 1e-4);
  }
  EXPECT_LT((map.constraints[0].from_from_to.matrix() - meters.constraints[0].from_from_to.matrix()).norm(), 1e-12);
  EXPECT_LT(distance(trajectory_of(map).back().world_from_body, trajectory_of(meters).back().world_from_body), 1e-12);
}

TEST(LandmarkCovariance, GrowsWithFewerViewsAndIsUndefinedWithOne) {
  const Map map = road_in_units(1.0);
  const auto seen_often = std::max_element(
      landmarks_of(map).begin(), landmarks_of(map).end(),
      [](const Landmark& a, const Landmark& b) { return a.observations.size() < b.observations.size(); });
  const auto covariance = landmark_covariance(map, *seen_often);
  ASSERT_TRUE(covariance);
  Landmark fewer = *seen_often;
  fewer.observations.resize(2);
  const auto more = landmark_covariance(map, fewer);
  ASSERT_TRUE(more);
  EXPECT_GT(more->trace(), covariance->trace());
  fewer.observations.resize(1);
  EXPECT_FALSE(landmark_covariance(map, fewer)) << "one camera leaves the distance open";
}

TEST(LandmarkCovariance, IsTheInverseOfTheInformationOfAllViews) {
  const Map map = road_in_units(0.37);
  const auto features = map.layer<FeatureLayer>();
  const Camera camera = TestRoad::camera();
  for (const std::size_t i : {5U, 90U, 300U}) {
    const Landmark& landmark = landmarks_of(map)[i];
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    for (const LandmarkObservation& observation : landmark.observations) {
      const SE3 camera_from_world = map.find(observation.keyframe)->world_from_camera.inverse();
      Eigen::Matrix<double, 2, 3> slope;  // derivative of pixels by position, by central differences
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d step = 1e-5 * Eigen::Vector3d::Unit(axis);
        slope.col(axis) = (*camera.project(camera_from_world * (landmark.position + step)) -
                           *camera.project(camera_from_world * (landmark.position - step))) /
                          2e-5;
      }
      const int level = features->find(observation.keyframe)->features.levels[observation.feature];
      const double sigma_px = std::pow(features->extraction.scale_factor, level);
      information += slope.transpose() * slope / (sigma_px * sigma_px);
    }
    const Eigen::Matrix3d expected = information.inverse();
    EXPECT_LT((*landmark_covariance(map, landmark) - expected).norm(), 1e-5 * expected.norm()) << i;
  }
  Map without_camera = map;
  without_camera.cameras.clear();
  EXPECT_FALSE(landmark_covariance(without_camera, landmarks_of(map)[5]));
}

TEST(LandmarkLayer, ALandmarkBelongsToTheSubmapOfItsFirstObserver) {
  Map map = make_landmark_test_map();
  const Landmark landmark = map.layer<LandmarkLayer>()->landmarks.front();
  ASSERT_FALSE(landmark.observations.empty());
  EXPECT_EQ(submap_of(map, landmark), 0);
  map.keyframes[*map.index_of(landmark.observations.front().keyframe)].submap = 3;
  EXPECT_EQ(submap_of(map, landmark), 3);
  EXPECT_EQ(submap_of(map, Landmark()), 0) << "nobody observed it";
}

}  // namespace
}  // namespace rastro
