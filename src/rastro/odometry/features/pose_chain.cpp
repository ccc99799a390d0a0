// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/features/pose_chain.h"

#include <algorithm>
#include <limits>

namespace rastro {

std::size_t PoseChain::add(const Record& record) {
  records_.push_back(record);
  last_image_ = records_.size() - 1;
  if (record.kind != Kind::unknown) last_known_ = last_image_;
  if (record.kind == Kind::anchored) note_anchored(last_image_);
  return last_image_;
}

void PoseChain::note_anchored(std::size_t record) {
  anchored_.insert(std::lower_bound(anchored_.begin(), anchored_.end(), record), record);
  last_known_ = std::max(last_known_.value_or(0), record);
  if (record == last_image_) at_rest_ = 0;
}

std::size_t PoseChain::add(TimeNs stamp, std::size_t keyframe, const SE3& camera_from_keyframe) {
  return add({stamp, Kind::anchored, keyframe, camera_from_keyframe});
}

std::size_t PoseChain::add_unknown(TimeNs stamp) { return add({stamp, Kind::unknown, 0, {}}); }

std::size_t PoseChain::add_repeated(TimeNs stamp) {
  if (records_.empty()) return add_unknown(stamp);
  at_rest_ += std::max<TimeNs>(0, stamp - records_.back().stamp);
  if (last_known_ && records_[*last_known_].kind == Kind::anchored) {
    last_image_ = *last_known_;  // images without a pose in between, as dark ones, were taken there, too
    at_rest_ = std::max<TimeNs>(0, stamp - records_[last_image_].stamp);
  }
  records_.push_back({stamp, Kind::unknown, 0, {}});
  return records_.size() - 1;
}

std::size_t PoseChain::add_predicted(TimeNs stamp, const LocalMap& map) {
  return add({stamp, Kind::guessed, 0, predicted(stamp, map)});
}

std::size_t PoseChain::repeat(TimeNs stamp) {
  Record record = last_known_ ? records_[*last_known_] : Record{};
  record.stamp = stamp;
  return add(record);
}

void PoseChain::set(std::size_t record, std::size_t keyframe, const SE3& camera_from_keyframe) {
  const bool known = records_[record].kind == Kind::anchored;
  records_[record].kind = Kind::anchored;
  records_[record].keyframe = keyframe;
  records_[record].camera_from_anchor = camera_from_keyframe;
  if (!known) note_anchored(record);
}

std::optional<SE3> PoseChain::pose_of(const Record& record, const LocalMap& map) const {
  if (record.kind == Kind::unknown) return std::nullopt;
  if (record.kind == Kind::guessed) return record.camera_from_anchor;
  return record.camera_from_anchor * map.keyframes()[record.keyframe].camera_from_world;
}

std::optional<std::pair<const PoseChain::Record*, const PoseChain::Record*>> PoseChain::last_two() const {
  if (anchored_.empty()) return std::nullopt;
  const Record& newer = records_[anchored_.back()];
  for (auto index = anchored_.rbegin(); index != anchored_.rend(); ++index) {
    if (records_[*index].stamp < newer.stamp) return std::pair{&records_[*index], &newer};
  }
  return std::nullopt;
}

SE3 PoseChain::predicted(TimeNs stamp, const LocalMap& map) const {
  const auto two = last_two();
  if (!two) return last_known_ ? *pose_of(records_[*last_known_], map) : SE3();
  const auto [before, last] = *two;
  const SE3 last_pose = *pose_of(*last, map);
  const SE3 world_from_last = last_pose.inverse(), world_from_before = pose_of(*before, map)->inverse();
  const double steps = static_cast<double>(stamp - last->stamp - at_rest_) /
                       static_cast<double>(std::max<TimeNs>(1, last->stamp - before->stamp));
  const Eigen::Vector3d moved = world_from_last.translation() - world_from_before.translation();
  constexpr double most_steps = 2.0;
  const SO3 step_rotation = world_from_before.rotation().inverse() * world_from_last.rotation();
  const SO3 rotation = world_from_last.rotation() * SO3::exp(std::clamp(steps, 0.0, most_steps) * step_rotation.log());
  return SE3(rotation, world_from_last.translation() + std::max(0.0, steps) * moved).inverse();
}

SE3 PoseChain::last_camera_from_world(const LocalMap& map) const {
  if (records_.empty()) return {};
  const auto pose = pose_of(records_[last_image_], map);
  return pose ? *pose : predicted(records_.back().stamp, map);
}

SE3 PoseChain::camera_from_world_at(TimeNs stamp, const LocalMap& map) const {
  const auto found =
      std::find_if(records_.rbegin(), records_.rend(), [=](const Record& record) { return record.stamp == stamp; });
  const auto pose = found == records_.rend() ? std::nullopt : pose_of(*found, map);
  return pose ? *pose : predicted(stamp, map);
}

std::optional<double> PoseChain::length_between(TimeNs begin, TimeNs end, const LocalMap& map) const {
  const Record* newer = nullptr;
  for (auto index = anchored_.rbegin(); index != anchored_.rend(); ++index) {
    const Record* record = &records_[*index];
    if (newer && record->stamp < newer->stamp) {
      const Eigen::Vector3d step =
          pose_of(*newer, map)->inverse().translation() - pose_of(*record, map)->inverse().translation();
      if (step.norm() >= 1e-9)
        return step.norm() * static_cast<double>(end - begin) / static_cast<double>(newer->stamp - record->stamp);
    }
    newer = record;
  }
  return std::nullopt;
}

Trajectory PoseChain::trajectory(const LocalMap& map) const {
  Trajectory known;
  for (const Record& record : records_) {
    const auto pose = pose_of(record, map);
    if (pose && (known.empty() || record.stamp > known.back().stamp)) known.push_back({record.stamp, pose->inverse()});
  }
  Trajectory all;
  for (const Record& record : records_) {
    StampedPose stamped{record.stamp, {}};
    const auto pose = pose_of(record, map);
    if (pose) {
      stamped.world_from_body = pose->inverse();
    } else if (!known.empty()) {
      const auto between = pose_at(known, record.stamp, std::numeric_limits<TimeNs>::max());
      const bool early = record.stamp <= known.front().stamp;
      stamped.world_from_body =
          between ? *between : (early ? known.front().world_from_body : known.back().world_from_body);
    }
    all.push_back(stamped);
  }
  return all;
}

}  // namespace rastro
