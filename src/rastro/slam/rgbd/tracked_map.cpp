// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rgbd/tracked_map.h"

#include <algorithm>

namespace rastro {

TrackedMap::TrackedMap(RgbdMap base, bool given) : base_(std::move(base)), given_(given) {
  keyframes_ = base_.keyframes;
  poses_ = base_.poses;
  edges_ = base_.edges;
  covariances_.assign(poses_.size(), Matrix6d::Zero());
  for (const KeyframePose& pose : poses_) submaps_ = std::max(submaps_, pose.submap + 1);
}

SE3 TrackedMap::pose(std::int64_t keyframe) const {
  const auto place = static_cast<std::size_t>(keyframe);
  return place < poses_.size() ? poses_[place].world_from_camera : pending_[place - poses_.size()].world_from_camera;
}

int TrackedMap::submap(std::int64_t keyframe) const {
  const auto place = static_cast<std::size_t>(keyframe);
  return place < poses_.size() ? poses_[place].submap : pending_[place - poses_.size()].submap;
}

void TrackedMap::add_pending(const KeyframePose& pose, const Matrix6d& covariance) {
  pending_.push_back(pose);
  covariances_.push_back(covariance);
}

void TrackedMap::move_pending(std::int64_t first, const SE3& new_world_from_world) {
  const auto known = static_cast<std::int64_t>(poses_.size());
  for (std::int64_t k = std::max(first, known); k < keyframe_count(); ++k) {
    SE3& pose = pending_[static_cast<std::size_t>(k - known)].world_from_camera;
    pose = new_world_from_world * pose;
  }
}

void TrackedMap::apply(MapRevision revision) {
  poses_ = std::move(revision.poses);
  if (revision.keyframe) {
    covariances_[static_cast<std::size_t>(revision.keyframe->id)] = revision.covariance;
    keyframes_.push_back(std::move(revision.keyframe));
    pending_.pop_front();
  }
  for (const std::int64_t id : revision.forgotten) {
    auto& keyframe = keyframes_[static_cast<std::size_t>(id)];
    auto bare = std::make_shared<RgbdKeyframe>();
    bare->id = keyframe->id;
    bare->frame = keyframe->frame;
    bare->stamp = keyframe->stamp;
    bare->features.length = keyframe->features.length;
    keyframe = std::move(bare);
  }
  edges_.insert(edges_.end(), revision.new_edges.begin(), revision.new_edges.end());
  for (std::size_t e = 0; e < edges_.size() && e < revision.weights.size(); ++e) edges_[e].weight = revision.weights[e];
  ++revision_;
}

void TrackedMap::add_frame(TimeNs stamp, std::int64_t keyframe, const SE3& keyframe_from_camera) {
  frames_.push_back({stamp, keyframe, keyframe_from_camera});
}

bool TrackedMap::make_largest_first() {
  std::vector<std::int64_t> frames(static_cast<std::size_t>(std::max(1, submaps_)), 0);
  for (const PlacedFrame& frame : frames_) ++frames[static_cast<std::size_t>(submap(frame.keyframe))];
  const auto largest = static_cast<int>(std::max_element(frames.begin(), frames.end()) - frames.begin());
  if (largest == 0 || given_) return false;
  for (KeyframePose& pose : poses_) {
    if (pose.submap == 0 || pose.submap == largest) pose.submap = largest - pose.submap;
  }
  ++revision_;
  return true;
}

Trajectory TrackedMap::trajectory() const {
  Trajectory trajectory;
  for (const PlacedFrame& frame : frames_) {
    if (submap(frame.keyframe) == 0)
      trajectory.push_back({frame.stamp, pose(frame.keyframe) * frame.keyframe_from_camera});
  }
  const auto before = [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; };
  std::stable_sort(trajectory.begin(), trajectory.end(), before);
  const auto same = [](const StampedPose& a, const StampedPose& b) { return a.stamp == b.stamp; };
  trajectory.erase(std::unique(trajectory.begin(), trajectory.end(), same), trajectory.end());
  return trajectory;
}

std::shared_ptr<const Snapshot> TrackedMap::snapshot() const {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->revision = revision_;
  auto map = std::make_shared<RgbdMap>(base_);
  if (!given_) {
    map->keyframes = keyframes_;
    map->poses = poses_;
    map->edges = edges_;
    map->trajectory = trajectory();
  }
  for (std::size_t k = 0; k < map->keyframes.size(); ++k)
    snapshot->keyframes.push_back({map->keyframes[k]->stamp, map->poses[k].world_from_camera});
  for (const PoseEdge& edge : map->edges)
    snapshot->edges.push_back({static_cast<std::size_t>(edge.from), static_cast<std::size_t>(edge.to),
                               edge.kind == PoseEdgeKind::loop || edge.kind == PoseEdgeKind::join});
  snapshot->rgbd = std::move(map);
  return snapshot;
}

}  // namespace rastro
