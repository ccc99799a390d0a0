// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/tracked_map.h"

#include <algorithm>
#include <utility>

#include "rastro/backend/rgbd/frame_report.h"

namespace rastro {

TrackedMap::TrackedMap(Map base, std::shared_ptr<const ImageStore> images, bool given,
                       std::shared_ptr<const SignatureStore> signatures)
    : base_(std::move(base)), images_(std::move(images)), signatures_(std::move(signatures)), given_(given) {
  const auto features = base_.layer<FeatureLayer>();
  for (const Keyframe& keyframe : base_.keyframes) {
    keyframes_.push_back(features->of.at(keyframe.id));
    poses_.push_back({keyframe.world_from_camera, keyframe.submap});
    weights_.push_back(keyframe.weight);
    submaps_ = std::max(submaps_, keyframe.submap + 1);
  }
  for (const Constraint& edge : base_.constraints) add_edge(edge);
  if (signatures_ || base_.layer<SignatureLayer>()) base_.layers.put(FeatureLayer::layer_name, nullptr);
  if (!given_) continue_base();
  covariances_.assign(poses_.size(), Matrix6d::Zero());
}

/// What the base has of its own is part of every snapshot again; its last session is this one.
void TrackedMap::continue_base() {
  if (!base_.keyframes.empty()) {
    MapSession session = base_.sessions.front();
    session.session = base_.sessions.back().session + 1;
    session.recording.clear();
    base_.sessions.push_back(session);
  }
  base_.keyframes.clear();
  base_.constraints.clear();
}

SE3 TrackedMap::pose(std::int64_t keyframe) const {
  const auto index = static_cast<std::size_t>(keyframe);
  return index < poses_.size() ? poses_[index].world_from_camera
                               : pending_[index - poses_.size()].pose.world_from_camera;
}

int TrackedMap::submap(std::int64_t keyframe) const {
  const auto index = static_cast<std::size_t>(keyframe);
  return index < poses_.size() ? poses_[index].submap : pending_[index - poses_.size()].pose.submap;
}

std::vector<std::int64_t> TrackedMap::nearest(const SE3& pose, int submap, const RgbdSlamOptions& options,
                                              bool bare) const {
  constexpr std::size_t most = 5;
  std::vector<std::pair<double, std::int64_t>> near;
  for (std::size_t k = 0; k < keyframes_.size(); ++k) {
    if (poses_[k].submap != submap || (!bare && keyframes_[k]->features.size() == 0)) continue;
    const SE3& other = poses_[k].world_from_camera;
    const double apart = (other.translation() - pose.translation()).norm() / options.near_distance_m;
    if (near.size() == most && apart >= near.back().first) continue;  // whatever its direction
    const double turned = (other.inverse() * pose).rotation().log().norm() / options.near_angle_rad;
    near.emplace_back(std::max(apart, turned), static_cast<std::int64_t>(k));
    std::sort(near.begin(), near.end());
    if (near.size() > most) near.pop_back();
  }
  std::vector<std::int64_t> ids;
  ids.reserve(near.size());
  for (const auto& [distance, id] : near) ids.push_back(id);
  return ids;
}

void TrackedMap::add_edge(const Constraint& edge) {
  edges_.push_back(edge);
  connected_.insert(std::minmax(edge.from, edge.to));
}

bool TrackedMap::are_connected(std::int64_t a, std::int64_t b) const { return connected_.contains(std::minmax(a, b)); }

void TrackedMap::add_pending(const KeyframePose& pose, std::int64_t from, const Matrix6d& covariance) {
  pending_.push_back({pose, from, covariance});
  covariances_.push_back(covariance_of(pending_.back()));
}

Matrix6d TrackedMap::covariance_of(const PendingKeyframe& keyframe) const {
  if (keyframe.from < 0) return keyframe.covariance;
  return chained(covariance(keyframe.from), pose(keyframe.from).inverse() * keyframe.pose.world_from_camera,
                 keyframe.covariance);
}

void TrackedMap::move_pending(std::int64_t first, const SE3& new_world_from_world, int submap) {
  const auto known = static_cast<std::int64_t>(poses_.size());
  for (std::int64_t k = std::max(first, known); k < keyframe_count(); ++k) {
    PendingKeyframe& keyframe = pending_[static_cast<std::size_t>(k - known)];
    keyframe.pose = {new_world_from_world * keyframe.pose.world_from_camera, submap};
    covariances_[static_cast<std::size_t>(k)] = covariance_of(keyframe);
  }
}

void TrackedMap::apply(MapRevision revision) {
  const GraphChanges& changes = revision.graph;
  poses_.resize(static_cast<std::size_t>(changes.first_pose) + changes.poses.size());
  std::copy(changes.poses.begin(), changes.poses.end(), poses_.begin() + changes.first_pose);
  for (const auto& [id, covariance] : changes.covariances) covariances_[static_cast<std::size_t>(id)] = covariance;
  if (revision.keyframe) {
    covariances_[static_cast<std::size_t>(revision.keyframe->id)] = revision.covariance;
    keyframes_.push_back(std::move(revision.keyframe));
    pending_.pop_front();
  }
  for (auto& keyframe : revision.retrieved) {
    const auto index = static_cast<std::size_t>(keyframe->id);
    keyframes_[index] = std::move(keyframe);
  }
  for (const std::int64_t id : revision.forgotten) {
    auto& keyframe = keyframes_[static_cast<std::size_t>(id)];
    keyframe = without_features(*keyframe);
  }
  weights_.resize(keyframes_.size(), 1.0);
  for (const auto& [id, weight] : revision.keyframe_weights) weights_[static_cast<std::size_t>(id)] = weight;
  if (revision.belief) places_.push_back(std::move(*revision.belief));
  for (const Constraint& edge : revision.new_edges) add_edge(edge);
  for (const auto& [edge, weight] : changes.weights) edges_[edge].weight = weight;
  ++revision_;
}

void TrackedMap::add_frame(TimeNs stamp, std::int64_t keyframe, const SE3& keyframe_from_camera) {
  frames_.push_back({stamp, keyframe, keyframe_from_camera});
}

std::vector<std::int64_t> TrackedMap::frames_per_submap() const {
  std::vector<std::int64_t> frames(static_cast<std::size_t>(std::max(1, submaps_)), 0);
  for (const PosedFrame& frame : frames_) ++frames[static_cast<std::size_t>(submap(frame.keyframe))];
  return frames;
}

bool TrackedMap::make_largest_first() {
  const auto frames = frames_per_submap();
  const auto largest = static_cast<int>(std::max_element(frames.begin(), frames.end()) - frames.begin());
  if (largest == 0 || given_ || base_.sessions.size() > 1) return false;  // a map continued keeps its frame
  for (KeyframePose& pose : poses_) {
    if (pose.submap == 0 || pose.submap == largest) pose.submap = largest - pose.submap;
  }
  ++revision_;
  return true;
}

int TrackedMap::trajectory_submap() const {
  const auto frames = frames_per_submap();
  if (frames.front() > 0 || given_) return 0;
  return static_cast<int>(std::max_element(frames.begin(), frames.end()) - frames.begin());
}

Trajectory TrackedMap::trajectory() const {
  Trajectory trajectory;
  const int shown = trajectory_submap();
  for (const PosedFrame& frame : frames_) {
    if (submap(frame.keyframe) == shown)
      trajectory.push_back({frame.stamp, pose(frame.keyframe) * frame.keyframe_from_camera});
  }
  const auto before = [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; };
  std::stable_sort(trajectory.begin(), trajectory.end(), before);
  const auto same = [](const StampedPose& a, const StampedPose& b) { return a.stamp == b.stamp; };
  trajectory.erase(std::unique(trajectory.begin(), trajectory.end(), same), trajectory.end());
  return trajectory;
}

std::shared_ptr<const Map> TrackedMap::snapshot() const {
  auto map = std::make_shared<Map>(base_);
  if (given_) return map;
  map->revision = revision_;
  auto features = std::make_shared<FeatureLayer>();
  auto images = std::make_shared<ImageLayer>();
  auto signatures = std::make_shared<SignatureLayer>();
  for (std::size_t k = 0; k < keyframes_.size(); ++k) {
    const ImageFeatures& image = *keyframes_[k];
    map->keyframes.push_back({image.id, image.frame, image.stamp, 0, poses_[k].world_from_camera, poses_[k].submap,
                              no_keyframe, weights_[k]});
    if (!signatures_) features->of[image.id] = keyframes_[k];
    images->keyframes.push_back(image.id);
    signatures->keyframes.push_back(image.id);
  }
  images->store = images_;
  signatures->store = signatures_;
  if (signatures_)
    map->layers.put<SignatureLayer>(std::move(signatures));
  else
    map->layers.put<FeatureLayer>(std::move(features));
  map->layers.put<ImageLayer>(std::move(images));
  map->constraints = edges_;
  for (const PosedFrame& frame : frames_)
    if (frame.keyframe < static_cast<std::int64_t>(poses_.size()))
      map->frames.push_back({frame.stamp, frame.keyframe, frame.keyframe_from_camera});
  if (map->frames.size() > base_.frames.size()) {
    map->sessions.back().first_stamp = frames_.front().stamp;
    map->sessions.back().last_stamp = map->frames.back().stamp;
  }
  return map;
}

}  // namespace rastro
