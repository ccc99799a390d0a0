// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "rastro/base/random.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {

/// A fully known ring road: a camera 1.65 m above flat ground drives once around between two walls. World: the first
/// camera, x right, y down, z forward; meters times `unit`.
struct TestRoad {
  CameraKind sensor = CameraKind::mono;
  int keyframes = 12;
  int landmarks = 600;
  double unit = 1.0;  ///< Map units per meter.

  static constexpr double camera_height_m = 1.65, radius_m = 12.0, baseline_m = 0.5;
  static constexpr int frames_between = 5;
  static constexpr TimeNs frame_ns = 33'333'333, first_stamp = 1'305'031'102'000'000'000;

  static Camera camera() {
    Camera camera;
    camera.width = 640, camera.height = 480;
    camera.fx = camera.fy = 400.0, camera.cx = 319.5, camera.cy = 239.5;
    return camera;
  }

  /// At a fraction (0..1) of the trajectory; meters.
  static SE3 world_from_camera(double share) {
    const double angle = 2.0 * std::numbers::pi * share;
    const Eigen::Vector3d center(radius_m, 0.0, 0.0);
    const SO3 rotation = SO3::exp({0.0, angle, 0.0});
    return {rotation, center + rotation * (-center)};
  }

  /// On the ground or on a wall; meters.
  static Eigen::Vector3d random_position(Random& random) {
    const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
    const bool ground = random.uniform() < 0.6;
    const double beside = ground ? random.uniform(-3.5, 3.5) : (random.uniform() < 0.5 ? -5.0 : 5.0);
    const double height = ground ? 0.0 : random.uniform(0.2, 4.0);
    const double r = radius_m + beside;
    return {radius_m - r * std::cos(angle), camera_height_m - height, r * std::sin(angle)};
  }
};

namespace test_road {

inline Descriptor random_descriptor(Random& random) {
  Descriptor descriptor;
  for (std::uint64_t& word : descriptor.words) word = random.next();
  return descriptor;
}

/// Adds the landmarks visible from keyframe k as its features and as observations of the landmarks.
inline void observe(const TestRoad& road, std::size_t k, const std::vector<Eigen::Vector3d>& positions_m,
                    Random& random, ImageFeatures& keyframe, std::vector<Landmark>& landmarks) {
  constexpr double farthest_m = 14.0;
  const SE3 camera_from_world = TestRoad::world_from_camera(static_cast<double>(k) / road.keyframes).inverse();
  const auto add_feature = [&](const Eigen::Vector2d& pixel, const Descriptor& descriptor, double depth_m) {
    keyframe.features.keypoints.push_back(
        {static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), 31.0F, 0.5F, 20.0F});
    keyframe.features.levels.push_back(static_cast<std::uint8_t>(keyframe.features.size() % 3));
    keyframe.features.descriptors.push_back(descriptor);
    const bool known = depth_m > 0.0 && road.sensor != CameraKind::mono;
    if (road.sensor == CameraKind::stereo)
      keyframe.right_x.push_back(
          known ? static_cast<float>(pixel.x() - TestRoad::camera().fx * TestRoad::baseline_m / depth_m) : -1.0F);
    if (road.sensor != CameraKind::mono) keyframe.depths.push_back(known ? static_cast<float>(depth_m) : 0.0F);
  };
  add_feature({3.0, 4.0}, random_descriptor(random), 0.0);
  for (std::size_t i = 0; i < positions_m.size(); ++i) {
    const Eigen::Vector3d seen = camera_from_world * positions_m[i];
    const auto pixel = TestRoad::camera().project(seen);
    if (!pixel || seen.z() > farthest_m || seen.z() < 0.5) continue;
    if (pixel->x() < 0.0 || pixel->y() < 0.0 || pixel->x() > 639.0 || pixel->y() > 479.0) continue;
    landmarks[i].observations.push_back({keyframe.id, static_cast<std::uint32_t>(keyframe.features.size())});
    landmarks[i].direction += (camera_from_world.rotation().inverse() * seen).normalized();
    add_feature(*pixel, landmarks[i].descriptor, seen.z());
  }
}

}  // namespace test_road

/// A map without noise. Ids have gaps, as in a map with removed keyframes and landmarks; a loop closure from the last
/// keyframe to the first one.
inline Map make_landmark_test_map(const TestRoad& road = {}) {
  Random random(11);
  Map map;
  map.method = "orb";
  const double baseline = road.sensor == CameraKind::stereo ? TestRoad::baseline_m : 0.0;
  map.cameras.push_back({road.sensor, TestRoad::camera(), baseline, {}, SE3()});
  map.sessions.push_back(
      {0, 0, "", 0, 0,
       road.sensor == CameraKind::mono ? MapScale{false, 0.0, "arbitrary"} : MapScale{true, 0.002, "stereo baseline"}});
  auto layer = std::make_shared<LandmarkLayer>();
  auto features = std::make_shared<FeatureLayer>();
  std::vector<Eigen::Vector3d> positions_m;
  for (int i = 0; i < road.landmarks; ++i) {
    positions_m.push_back(TestRoad::random_position(random));
    Landmark landmark;
    landmark.id = i + i / 10;
    landmark.position = road.unit * positions_m.back();
    landmark.descriptor = test_road::random_descriptor(random);
    landmark.min_distance = static_cast<float>(0.5 * road.unit);
    landmark.max_distance = static_cast<float>(20.0 * road.unit);
    layer->landmarks.push_back(landmark);
  }
  const auto in_units = [&](double share) {
    const SE3 pose = TestRoad::world_from_camera(share);
    return SE3(pose.rotation(), road.unit * pose.translation());
  };
  for (int k = 0; k < road.keyframes; ++k) {
    auto image = std::make_shared<ImageFeatures>();
    image->id = k + k / 5;
    image->frame = std::int64_t{k} * TestRoad::frames_between;
    image->stamp = TestRoad::first_stamp + image->frame * TestRoad::frame_ns;
    test_road::observe(road, static_cast<std::size_t>(k), positions_m, random, *image, layer->landmarks);
    map.keyframes.push_back({image->id, image->frame, image->stamp, 0,
                             in_units(static_cast<double>(k) / road.keyframes), 0,
                             k == 0 ? no_keyframe : map.keyframes.back().id, 1.0});
    features->of[image->id] = image;
  }
  std::erase_if(layer->landmarks, [](const Landmark& landmark) { return landmark.observations.size() < 2; });
  for (Landmark& landmark : layer->landmarks) landmark.direction.normalize();
  map.layers.put<FeatureLayer>(std::move(features));
  map.layers.put<LandmarkLayer>(std::move(layer));
  for (int f = 0; f <= (road.keyframes - 1) * TestRoad::frames_between; ++f)
    map.frames.push_back(
        *frame_in(map, {TestRoad::first_stamp + f * TestRoad::frame_ns,
                        in_units(static_cast<double>(f) / (road.keyframes * TestRoad::frames_between))}));
  Constraint loop_closure;
  loop_closure.from = map.keyframes.back().id, loop_closure.to = 0, loop_closure.kind = ConstraintKind::loop,
  loop_closure.inliers = 40;
  loop_closure.from_from_to =
      Sim3(map.keyframes.back().world_from_camera.inverse() * map.keyframes.front().world_from_camera);
  map.constraints.push_back(loop_closure);
  return map;
}

}  // namespace rastro
