// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "rastro/base/random.h"
#include "rastro/feature/descriptor_extractor.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/images/pack_images.h"

namespace rastro {

/// A fully known room with one blue box on its floor. World: z up, meters.
namespace test_room {

inline const Eigen::Vector3d low(-2.0, -1.5, 0.0), high(2.0, 1.5, 2.4);
inline const Eigen::Vector3d box_low(0.95, -0.2, 0.0), box_high(1.45, 0.6, 0.6);

inline Camera camera() {
  Camera camera;
  camera.width = 320, camera.height = 240;
  camera.fx = camera.fy = 260.0, camera.cx = 159.5, camera.cy = 119.5;
  return camera;
}

/// Pose of keyframe `number` of `count`: from one side of the room to the other, facing along x and down.
inline SE3 world_from_camera(int number, int count) {
  const double share = count > 1 ? static_cast<double>(number) / (count - 1) : 0.5;
  const double yaw = 0.2 - 0.4 * share, pitch = -0.25;
  const Eigen::Vector3d ahead(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch), std::sin(pitch));
  const Eigen::Vector3d right = ahead.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d axes;
  axes << right, ahead.cross(right), ahead;
  return {SO3(Eigen::Quaterniond(axes)), {-1.2, -0.6 + 1.2 * share, 1.2}};
}

struct Hit {
  double distance = 0.0;
  int face = 0;  ///< 0..5 the room's walls, 6..11 the box.
};

/// The first surface along a ray that starts inside the room and outside the box.
inline Hit trace(const Eigen::Vector3d& from, const Eigen::Vector3d& along) {
  Hit hit{1e9, 0};
  double box_in = 0.0, box_out = 1e9;
  int box_face = 6;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(along[axis]) < 1e-12) {
      if (from[axis] < box_low[axis] || from[axis] > box_high[axis]) box_out = -1.0;
      continue;
    }
    const bool up = along[axis] > 0.0;
    const double wall = ((up ? high : low)[axis] - from[axis]) / along[axis];
    if (wall < hit.distance) hit = {wall, 2 * axis + (up ? 1 : 0)};
    const double in = ((up ? box_low : box_high)[axis] - from[axis]) / along[axis];
    const double out = ((up ? box_high : box_low)[axis] - from[axis]) / along[axis];
    if (in > box_in) box_in = in, box_face = 6 + 2 * axis + (up ? 0 : 1);
    box_out = std::min(box_out, out);
  }
  if (box_in > 0.0 && box_in < box_out && box_in < hit.distance) hit = {box_in, box_face};
  return hit;
}

/// Patches of 4 cm in shades of one color per wall; the box is blue.
inline std::array<std::uint8_t, 3> color_at(const Eigen::Vector3d& point, int face) {
  std::uint64_t patch = static_cast<std::uint64_t>(face);
  for (int axis = 0; axis < 3; ++axis)
    if (axis != face % 6 / 2) patch = patch * 1009 + static_cast<std::uint64_t>(std::floor(point[axis] / 0.04) + 500.0);
  const double shade = 0.4 + 0.6 * Random(patch).uniform();
  const double walls[6][3] = {{200, 180, 150}, {220, 220, 200}, {150, 200, 160},
                              {210, 160, 160}, {140, 120, 100}, {240, 240, 240}};
  const double box[3] = {40, 70, 230};
  const double* base = face < 6 ? walls[face] : box;
  return {static_cast<std::uint8_t>(base[0] * shade), static_cast<std::uint8_t>(base[1] * shade),
          static_cast<std::uint8_t>(base[2] * shade)};
}

/// The camera's frame, without noise.
inline Frame frame_from(const SE3& world_from_camera, const Camera& camera = test_room::camera()) {
  Frame frame;
  frame.color.rgb = Image<std::uint8_t>(3 * camera.width, camera.height);
  frame.depth = DepthImage(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d ray((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1.0);
      const Eigen::Vector3d along = world_from_camera.rotation() * ray;
      const Hit hit = trace(world_from_camera.translation(), along);
      const auto color = color_at(world_from_camera.translation() + hit.distance * along, hit.face);
      std::copy(color.begin(), color.end(), frame.color.rgb.row(y) + 3 * x);
      frame.depth.at(x, y) = static_cast<float>(hit.distance);  // the ray has unit depth
    }
  }
  frame.image = gray_from_color(frame.color);
  return frame;
}

inline std::shared_ptr<const ImageFeatures> features_of(const Frame& frame, KeyframeId id) {
  auto keyframe = std::make_shared<ImageFeatures>();
  keyframe->id = id;
  keyframe->frame = frame.index;
  keyframe->stamp = frame.stamp;
  DescriptorExtractorOptions options;
  options.max_keypoints = 200;
  keyframe->features = DescriptorExtractor::create(DescriptorKind::orb, options)->extract(frame.image);
  for (const Keypoint& point : keyframe->features.keypoints)
    keyframe->depths.push_back(frame.depth.at(static_cast<int>(point.x + 0.5F), static_cast<int>(point.y + 0.5F)));
  return keyframe;
}

}  // namespace test_room

/// A map of the room with `keyframes` keyframes and exact poses: five frames from one keyframe to the next at 30
/// frames/s, an odometry constraint between neighbors and a loop closure from the last to the first.
inline Map make_test_map(int keyframes = 6) {
  constexpr int frames_between = 5;
  constexpr TimeNs frame_ns = 33'333'333;
  Map map;
  map.method = "rgbd";
  map.cameras.push_back({CameraKind::depth, test_room::camera(), 0.0, {}, SE3()});
  map.sessions.push_back({0, 0, "", 0, 0, {true, 0.0, "depth camera"}});
  auto features = std::make_shared<FeatureLayer>();
  auto images = std::make_shared<ImageLayer>();
  auto image_store = std::make_shared<MemoryImages>();
  for (int k = 0; k < keyframes; ++k) {
    const SE3 pose = test_room::world_from_camera(k, keyframes);
    Frame frame = test_room::frame_from(pose);
    frame.index = k * frames_between;
    frame.stamp = 1'305'031'102'000'000'000 + frame.index * frame_ns;
    const SE3 before = k == 0 ? pose : map.keyframes.back().world_from_camera;
    map.keyframes.push_back({k, frame.index, frame.stamp, 0, pose, 0, no_keyframe, 1.0});
    features->of[k] = test_room::features_of(frame, k);
    images->keyframes.push_back(k);
    image_store->add(k, pack_images(frame));
    for (int i = k == 0 ? 0 : 1 - frames_between; i <= 0; ++i) {
      const double share = 1.0 + static_cast<double>(i) / frames_between;
      const SE3 world_from_camera = k == 0 ? pose : interpolate(before, pose, share);
      map.frames.push_back({frame.stamp + i * frame_ns, k, pose.inverse() * world_from_camera});
    }
  }
  images->store = image_store;
  map.layers.put<FeatureLayer>(std::move(features));
  map.layers.put<ImageLayer>(std::move(images));
  const auto constrain = [&map](int from, int to, ConstraintKind kind) {
    Constraint constraint;
    constraint.from = from, constraint.to = to, constraint.kind = kind;
    constraint.from_from_to = Sim3(map.keyframes[static_cast<std::size_t>(from)].world_from_camera.inverse() *
                                   map.keyframes[static_cast<std::size_t>(to)].world_from_camera);
    constraint.information.diagonal() << 1e4, 1e4, 1e4, 4e4, 4e4, 4e4;
    map.constraints.push_back(constraint);
  };
  for (int k = 1; k < keyframes; ++k) constrain(k - 1, k, ConstraintKind::odometry);
  if (keyframes > 2) constrain(keyframes - 1, 0, ConstraintKind::loop);
  return map;
}

}  // namespace rastro
