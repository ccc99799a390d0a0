// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "rastro/backend/rgbd/keyframe_features.h"
#include "rastro/backend/rgbd/keyframe_graph.h"
#include "rastro/backend/rgbd/options.h"
#include "rastro/map/images/pack_images.h"
#include "rastro/map/images/room_map_testing.h"
#include "rastro/math/math_testing.h"

/// For tests of slam/rgbd only: views of the room of map/images/room_map_testing.h with exact poses, and parts of a
/// map.
namespace rastro::testing {

/// A camera at `position` in the room. `yaw` of the optical axis is from x towards y, `pitch` above the horizon;
/// radians.
inline SE3 looking(const Eigen::Vector3d& position, double yaw, double pitch = -0.25) {
  const Eigen::Vector3d ahead(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch), std::sin(pitch));
  const Eigen::Vector3d right = ahead.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d axes;
  axes << right, ahead.cross(right), ahead;
  return {SO3(Eigen::Quaterniond(axes)), position};
}

/// The room from `world_from_camera`, as the frame `index` of a recording of 30 frames/s.
inline Frame room_frame(const SE3& world_from_camera, std::int64_t index = 0) {
  Frame frame = test_room::frame_from(world_from_camera);
  frame.index = index;
  frame.stamp = frame.depth_stamp = 1000 * ns_per_second + index * (ns_per_second / 30);
  return frame;
}

/// Depth with the noise that the options assume: sigma(z) = a + b z^2.
inline Frame with_depth_noise(Frame frame, const RgbdSlamOptions& options, std::uint64_t seed) {
  Random random(seed);
  for (int y = 0; y < frame.depth.height(); ++y) {
    for (int x = 0; x < frame.depth.width(); ++x) {
      const auto depth = static_cast<double>(frame.depth.at(x, y));
      const double sigma = options.follow.depth_sigma_m + options.follow.depth_sigma_per_m2 * depth * depth;
      frame.depth.at(x, y) = static_cast<float>(depth + sigma * random.normal());
    }
  }
  return frame;
}

/// A frame unrelated to all others: blocks of random intensity at the constant depth `depth_m`.
inline Frame unknown_frame(std::uint64_t seed, float depth_m = 2.0F) {
  const Camera camera = test_room::camera();
  Frame frame;
  frame.image = GrayImage(camera.width, camera.height);
  frame.depth = DepthImage(camera.width, camera.height);
  Random random(seed);
  for (int y = 0; y < camera.height; y += 4) {
    for (int x = 0; x < camera.width; x += 4) {
      const auto shade = static_cast<std::uint8_t>(40 + random.below(200));
      for (int j = 0; j < 4; ++j) {
        for (int i = 0; i < 4; ++i) frame.image.at(x + i, y + j) = shade, frame.depth.at(x + i, y + j) = depth_m;
      }
    }
  }
  return frame;
}

/// A keyframe of `frame`, with features and depths as the method itself makes them.
inline std::shared_ptr<const ImageFeatures> room_keyframe(const Frame& frame, std::int64_t id,
                                                          const RgbdSlamOptions& options) {
  ImageFeatures keyframe = KeyframeFeatures(options).extract(frame);
  keyframe.id = id;
  return std::make_shared<const ImageFeatures>(std::move(keyframe));
}

/// A keyframe with only its number and a number of features.
inline std::shared_ptr<const ImageFeatures> bare_keyframe(std::int64_t id, std::size_t features = 1) {
  auto keyframe = std::make_shared<ImageFeatures>();
  keyframe->id = id;
  keyframe->frame = 10 * id;
  keyframe->stamp = 1000 * id;
  keyframe->features.keypoints.resize(features);
  keyframe->features.descriptors.resize(features);
  keyframe->depths.assign(features, 1.0F);
  return keyframe;
}

inline KeyframePose in_submap(const SE3& world_from_camera, int submap = 0) { return {world_from_camera, submap}; }

inline Constraint edge_of(std::int64_t from, std::int64_t to, const SE3& from_from_to,
                          ConstraintKind kind = ConstraintKind::odometry, double sigma_m = 0.01,
                          double sigma_rad = 0.005) {
  Constraint edge;
  edge.from = from;
  edge.to = to;
  edge.from_from_to = Sim3(from_from_to);
  edge.kind = kind;
  edge.information.setIdentity();
  edge.information.topLeftCorner<3, 3>() /= sigma_m * sigma_m;
  edge.information.bottomRightCorner<3, 3>() /= sigma_rad * sigma_rad;
  return edge;
}

/// Images in memory; counts the requests.
class CountingImages : public ImageStore {
 public:
  void add(std::int64_t id, const Frame& frame) { kept_.add(id, pack_images(frame)); }
  PackedImages read(std::int64_t id) const override {
    ++asked_;
    return kept_.read(id);
  }
  int asked() const { return asked_; }

 private:
  MemoryImages kept_;
  mutable std::atomic<int> asked_ = 0;
};

}  // namespace rastro::testing
