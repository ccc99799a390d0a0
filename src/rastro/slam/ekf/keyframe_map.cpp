// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/keyframe_map.h"

#include <Eigen/LU>
#include <memory>
#include <numbers>
#include <utility>

#include "rastro/map/graph/planar.h"
#include "rastro/slam/ekf/motion_model.h"

namespace rastro {

bool KeyframeMap::is_new_keyframe(const SE3& world_from_body) const {
  if (keyframes_.empty()) return true;
  const SE3 motion = keyframes_.back().world_from_camera.inverse() * world_from_body;
  return motion.translation().norm() >= options_.keyframe_m ||
         motion.rotation().log().norm() * 180.0 / std::numbers::pi >= options_.keyframe_deg;
}

void KeyframeMap::add(const Frame& frame, const SE2& world_from_body, bool maps, std::size_t scans_every) {
  const SE3 pose = in_space(world_from_body);
  trajectory_.push_back({frame.stamp, pose});
  if ((maps || keyframes_.empty()) && is_new_keyframe(pose)) {
    const auto id = static_cast<KeyframeId>(keyframes_.size());
    keyframes_.push_back({id, frame.index, frame.stamp, 0, pose, 0, id - 1, 1.0});
    scans_.begin_keyframe();
  }
  keyframe_of_frame_.push_back(keyframes_.back().id);
  if (!frame.scan || !grid_ || !maps) return;
  const SE2 keyframe_from_body = in_plane(keyframes_.back().world_from_camera).inverse() * world_from_body;
  scans_.add(*frame.scan, keyframe_from_body, world_from_body, scans_every);
}

std::size_t KeyframeMap::bytes() const {
  return scans_.bytes() + trajectory_.size() * (sizeof(StampedPose) + sizeof(KeyframeId)) +
         keyframes_.size() * sizeof(Keyframe);
}

void KeyframeMap::put_into(Map& map) const {
  map.keyframes = keyframes_;
  put_constraints_into(map);
  for (std::size_t i = 0; i < trajectory_.size(); ++i) {
    const Keyframe& keyframe = keyframes_[static_cast<std::size_t>(keyframe_of_frame_[i])];
    map.frames.push_back(
        {trajectory_[i].stamp, keyframe.id, keyframe.world_from_camera.inverse() * trajectory_[i].world_from_body});
  }
  const TimeNs first = trajectory_.empty() ? 0 : trajectory_.front().stamp;
  const TimeNs last = trajectory_.empty() ? 0 : trajectory_.back().stamp;
  map.sessions.push_back({0, 0, "", first, last, {true, 0.0, "wheel odometry and laser"}});
  put_scans_into(map);
}

void KeyframeMap::put_constraints_into(Map& map) const {
  for (std::size_t i = 1; i < keyframes_.size(); ++i) {
    const SE2 motion = in_plane(keyframes_[i - 1].world_from_camera.inverse() * keyframes_[i].world_from_camera);
    constexpr double least_variance = 1e-8;  // a robot that only rotated knows its position, but not with infinite
                                             // precision
    Eigen::Matrix3d covariance = measured_motion(motion, options_).covariance;
    covariance.diagonal().array() += least_variance;
    map.constraints.push_back(planar_constraint(keyframes_[i - 1].id, keyframes_[i].id, motion, covariance.inverse(),
                                                ConstraintKind::odometry));
  }
}

void KeyframeMap::put_scans_into(Map& map) const {
  auto layer = std::make_shared<ScanLayer>();
  layer->cell_m = options_.cell_m;
  for (std::size_t i = 0; i < keyframes_.size(); ++i)
    if (auto scans = scans_.of(i)) layer->of[keyframes_[i].id] = std::move(scans);
  if (!layer->of.empty()) map.layers.put<ScanLayer>(std::move(layer));
}

}  // namespace rastro
