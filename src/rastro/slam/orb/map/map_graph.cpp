// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/map_graph.h"

#include <algorithm>
#include <limits>

#include "rastro/base/error.h"
#include "rastro/feature/hamming.h"

namespace rastro {
namespace {

void insert_sorted(std::vector<std::int64_t>& ids, std::int64_t id) {
  ids.insert(std::lower_bound(ids.begin(), ids.end(), id), id);
}

void erase_sorted(std::vector<std::int64_t>& ids, std::int64_t id) {
  const auto at = std::lower_bound(ids.begin(), ids.end(), id);
  if (at != ids.end() && *at == id) ids.erase(at);
}

auto place_of(std::vector<LandmarkObservation>& observations, std::int64_t keyframe) {
  return std::lower_bound(observations.begin(), observations.end(), keyframe,
                          [](const LandmarkObservation& o, std::int64_t id) { return o.keyframe < id; });
}

SE3 scaled(const SE3& pose, double factor) { return {pose.rotation(), factor * pose.translation()}; }

}  // namespace

MapGraph::MapGraph(const Camera& camera, CameraKind sensor, double baseline, const OrbOptions& features)
    : camera_(camera),
      sensor_(sensor),
      baseline_(baseline),
      orb_options_(features),
      level_scales_(orb_level_scales(features)) {}

double MapGraph::sigma(const FeatureFrame& frame, std::size_t feature) const {
  return level_scales_[frame.level(feature)] / camera_.fx;
}

MapKeyframe& MapGraph::add_keyframe(std::shared_ptr<const FeatureFrame> frame, const SE3& camera_from_world, int submap,
                                    std::int64_t parent) {
  const std::int64_t id = frame->data().id;
  RASTRO_CHECK(id >= static_cast<std::int64_t>(keyframes_.size()), "ids of keyframes ascend");
  keyframes_.resize(static_cast<std::size_t>(id) + 1);
  auto keyframe = std::make_unique<MapKeyframe>();
  keyframe->id = id;
  keyframe->landmarks.assign(frame->size(), -1);
  keyframe->frame = std::move(frame);
  keyframe->camera_from_world = camera_from_world;
  keyframe->submap = submap;
  submaps_ = std::max(submaps_, submap + 1);
  auto& slot = keyframes_[static_cast<std::size_t>(id)];
  slot = std::move(keyframe);
  ++keyframe_count_;
  if (parent >= 0) {
    slot->unit = this->keyframe(parent).unit;
    set_parent(id, parent);
  }
  return *slot;
}

bool MapGraph::has_keyframe(std::int64_t id) const {
  return id >= 0 && id < static_cast<std::int64_t>(keyframes_.size()) && keyframes_[static_cast<std::size_t>(id)];
}

MapKeyframe& MapGraph::keyframe(std::int64_t id) {
  RASTRO_CHECK(has_keyframe(id), "the keyframe exists");
  return *keyframes_[static_cast<std::size_t>(id)];
}

const MapKeyframe& MapGraph::keyframe(std::int64_t id) const {
  RASTRO_CHECK(has_keyframe(id), "the keyframe exists");
  return *keyframes_[static_cast<std::size_t>(id)];
}

std::vector<std::int64_t> MapGraph::keyframe_ids() const {
  std::vector<std::int64_t> ids;
  for (const auto& keyframe : keyframes_) {
    if (keyframe) ids.push_back(keyframe->id);
  }
  return ids;
}

std::vector<std::int64_t> MapGraph::keyframe_ids(int submap) const {
  std::vector<std::int64_t> ids;
  for (const auto& keyframe : keyframes_) {
    if (keyframe && keyframe->submap == submap) ids.push_back(keyframe->id);
  }
  return ids;
}

void MapGraph::remove_keyframe(std::int64_t id) {
  MapKeyframe& gone = keyframe(id);
  RASTRO_CHECK(gone.parent >= 0, "the root of a submap stays");
  const MapKeyframe& parent = keyframe(gone.parent);
  removed_[id] = {gone.parent, gone.camera_from_world * parent.camera_from_world.inverse(), parent.unit, gone.unit};
  const std::size_t least = sensor_ == CameraKind::mono ? 2 : 1;
  const std::vector<std::int64_t> seen = gone.landmarks;
  for (const std::int64_t landmark_id : seen) {
    if (landmark_id < 0) continue;
    remove_observation(id, landmark_id);
    if (landmark(landmark_id).observations.size() < least) remove_landmark(landmark_id);
  }
  // Children go where they share most: to the parent, or to a sibling that is placed already.
  std::vector<std::int64_t> placed{gone.parent}, left = gone.children;
  while (!left.empty()) {
    std::int64_t best_child = left.front(), best_parent = placed.front();
    int best = -1;
    for (const std::int64_t child : left) {
      for (const std::int64_t candidate : placed) {
        const int count = shared(child, candidate);
        if (count > best) {
          best = count;
          best_child = child;
          best_parent = candidate;
        }
      }
    }
    set_parent(best_child, best_parent);
    placed.push_back(best_child);
    std::erase(left, best_child);
  }
  erase_sorted(keyframe(gone.parent).children, id);
  std::erase_if(ties_, [&](const Constraint& tie) { return tie.from == id || tie.to == id; });
  keyframes_[static_cast<std::size_t>(id)].reset();
  --keyframe_count_;
}

void MapGraph::remove_root(std::int64_t id) {
  RASTRO_CHECK(keyframe(id).children.empty(), "a root that is removed stands alone");
  const std::vector<std::int64_t> seen = keyframe(id).landmarks;
  for (const std::int64_t landmark_id : seen) {
    if (landmark_id >= 0) remove_landmark(landmark_id);
  }
  keyframes_[static_cast<std::size_t>(id)].reset();
  --keyframe_count_;
}

SE3 MapGraph::camera_from_world(std::int64_t id) const {
  if (has_keyframe(id)) return keyframe(id).camera_from_world;
  const Removed& gone = removed_.at(id);
  return scaled(gone.keyframe_from_parent, unit(gone.parent) / gone.parent_unit) * camera_from_world(gone.parent);
}

double MapGraph::unit(std::int64_t id) const {
  if (has_keyframe(id)) return keyframe(id).unit;
  const Removed& gone = removed_.at(id);
  return gone.unit * unit(gone.parent) / gone.parent_unit;
}

int MapGraph::submap(std::int64_t id) const {
  return has_keyframe(id) ? keyframe(id).submap : submap(removed_.at(id).parent);
}

void MapGraph::set_parent(std::int64_t child, std::int64_t parent) {
  MapKeyframe& keyframe = this->keyframe(child);
  if (has_keyframe(keyframe.parent)) erase_sorted(this->keyframe(keyframe.parent).children, child);
  keyframe.parent = parent;
  if (parent >= 0) insert_sorted(this->keyframe(parent).children, child);
}

void MapGraph::make_root(std::int64_t id) {
  std::int64_t above = keyframe(id).parent, below = id;
  set_parent(id, -1);
  while (above >= 0) {
    const std::int64_t next = keyframe(above).parent;
    set_parent(above, below);
    below = above;
    above = next;
  }
}

MapLandmark& MapGraph::add_landmark(const Eigen::Vector3d& position, std::int64_t keyframe) {
  auto landmark = std::make_unique<MapLandmark>();
  landmark->id = static_cast<std::int64_t>(landmarks_.size());
  landmark->position = position;
  landmark->first_keyframe = keyframe;
  landmarks_.push_back(std::move(landmark));
  ++landmark_count_;
  return *landmarks_.back();
}

void MapGraph::restore_landmark(const Landmark& landmark) {
  RASTRO_CHECK(landmark.id >= static_cast<std::int64_t>(landmarks_.size()), "ids of landmarks ascend");
  landmarks_.resize(static_cast<std::size_t>(landmark.id));
  MapLandmark& restored =
      add_landmark(landmark.position, landmark.observations.empty() ? -1 : landmark.observations.front().keyframe);
  restored.direction = landmark.direction;
  restored.descriptor = landmark.descriptor;
  restored.min_distance = landmark.min_distance;
  restored.max_distance = landmark.max_distance;
  for (const LandmarkObservation& o : landmark.observations) add_observation(o.keyframe, o.feature, restored.id);
}

bool MapGraph::has_landmark(std::int64_t id) const {
  return id >= 0 && id < static_cast<std::int64_t>(landmarks_.size()) && landmarks_[static_cast<std::size_t>(id)];
}

MapLandmark& MapGraph::landmark(std::int64_t id) {
  RASTRO_CHECK(has_landmark(id), "the landmark exists");
  return *landmarks_[static_cast<std::size_t>(id)];
}

const MapLandmark& MapGraph::landmark(std::int64_t id) const {
  RASTRO_CHECK(has_landmark(id), "the landmark exists");
  return *landmarks_[static_cast<std::size_t>(id)];
}

std::int64_t MapGraph::current(std::int64_t id) const {
  while (id >= 0 && !has_landmark(id)) {
    const auto next = fused_into_.find(id);
    id = next == fused_into_.end() ? -1 : next->second;
  }
  return id;
}

std::vector<std::int64_t> MapGraph::landmark_ids() const {
  std::vector<std::int64_t> ids;
  for (const auto& landmark : landmarks_) {
    if (landmark) ids.push_back(landmark->id);
  }
  return ids;
}

void MapGraph::remove_landmark(std::int64_t id) {
  MapLandmark& gone = landmark(id);
  while (!gone.observations.empty()) remove_observation(gone.observations.back().keyframe, id);
  landmarks_[static_cast<std::size_t>(id)].reset();
  --landmark_count_;
}

void MapGraph::fuse(std::int64_t kept, std::int64_t gone) {
  if (kept == gone) return;
  const std::vector<LandmarkObservation> observations = landmark(gone).observations;
  const int visible = landmark(gone).visible, found = landmark(gone).found;
  remove_landmark(gone);
  for (const LandmarkObservation& o : observations) add_observation(o.keyframe, o.feature, kept);
  landmark(kept).visible += visible;
  landmark(kept).found += found;
  fused_into_[gone] = kept;
  describe(kept);
}

void MapGraph::add_observation(std::int64_t keyframe, std::uint32_t feature, std::int64_t landmark) {
  MapKeyframe& observer = this->keyframe(keyframe);
  MapLandmark& seen = this->landmark(landmark);
  const auto at = place_of(seen.observations, keyframe);
  if (observer.landmarks[feature] >= 0 || (at != seen.observations.end() && at->keyframe == keyframe)) return;
  for (const LandmarkObservation& other : seen.observations) count(keyframe, other.keyframe, 1);
  seen.observations.insert(at, {keyframe, feature});
  observer.landmarks[feature] = landmark;
}

void MapGraph::remove_observation(std::int64_t keyframe, std::int64_t landmark) {
  MapLandmark& seen = this->landmark(landmark);
  const auto at = place_of(seen.observations, keyframe);
  if (at == seen.observations.end() || at->keyframe != keyframe) return;
  this->keyframe(keyframe).landmarks[at->feature] = -1;
  seen.observations.erase(at);
  for (const LandmarkObservation& other : seen.observations) count(keyframe, other.keyframe, -1);
}

void MapGraph::count(std::int64_t a, std::int64_t b, int change) {
  const auto change_one = [&](std::int64_t of, std::int64_t with) {
    std::vector<Neighbor>& list = keyframe(of).neighbors;
    auto at =
        std::lower_bound(list.begin(), list.end(), with, [](const Neighbor& n, std::int64_t id) { return n.id < id; });
    if (at == list.end() || at->id != with) at = list.insert(at, {with, 0});
    at->shared += change;
    if (at->shared <= 0) list.erase(at);
  };
  change_one(a, b);
  change_one(b, a);
}

std::int64_t MapGraph::feature_of(std::int64_t keyframe, std::int64_t landmark) const {
  for (const LandmarkObservation& o : this->landmark(landmark).observations) {
    if (o.keyframe == keyframe) return o.feature;
  }
  return -1;
}

void MapGraph::describe(std::int64_t landmark) {
  MapLandmark& l = this->landmark(landmark);
  if (l.observations.empty()) return;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::vector<Descriptor> descriptors;
  for (const LandmarkObservation& o : l.observations) {
    const MapKeyframe& keyframe = this->keyframe(o.keyframe);
    const Eigen::Vector3d in_camera = keyframe.camera_from_world * l.position;
    sum += keyframe.camera_from_world.rotation().inverse() * in_camera.normalized();
    descriptors.push_back(keyframe.frame->descriptor(o.feature));
    if (o.keyframe == l.first_keyframe || o == l.observations.front()) {
      const double distance = in_camera.norm();
      const double scale = level_scales_[keyframe.frame->level(o.feature)];
      l.max_distance = static_cast<float>(distance * scale);
      l.min_distance = static_cast<float>(distance * scale / level_scales_.back());
    }
  }
  l.direction = sum.norm() > 0.0 ? sum.normalized() : Eigen::Vector3d::UnitZ();
  std::vector<std::uint16_t> distances(descriptors.size());
  int best = std::numeric_limits<int>::max();
  for (const Descriptor& candidate : descriptors) {
    hamming_distances(candidate, descriptors, distances);
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>((distances.size() - 1) / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    if (*middle < best) {
      best = *middle;
      l.descriptor = candidate;
    }
  }
}

std::vector<Neighbor> MapGraph::covisible(std::int64_t keyframe, int least, std::size_t count) const {
  std::vector<Neighbor> list;
  for (const Neighbor& n : this->keyframe(keyframe).neighbors) {
    if (n.shared >= least) list.push_back(n);
  }
  std::stable_sort(list.begin(), list.end(), [](const Neighbor& a, const Neighbor& b) { return a.shared > b.shared; });
  if (count > 0 && list.size() > count) list.resize(count);
  return list;
}

int MapGraph::shared(std::int64_t a, std::int64_t b) const {
  for (const Neighbor& n : keyframe(a).neighbors) {
    if (n.id == b) return n.shared;
  }
  return 0;
}

void MapGraph::transform(int submap, const Sim3& new_from_old) {
  const double scale = new_from_old.scale();
  for (const auto& l : landmarks_) {
    if (!l || l->observations.empty() || keyframe(l->observations.front().keyframe).submap != submap) continue;
    l->position = new_from_old * l->position;
    l->direction = new_from_old.rotation() * l->direction;
    l->min_distance *= static_cast<float>(scale);
    l->max_distance *= static_cast<float>(scale);
  }
  const SO3 turn_back = new_from_old.rotation().inverse();
  for (const auto& k : keyframes_) {
    if (!k || k->submap != submap) continue;
    const SO3 rotation = k->camera_from_world.rotation() * turn_back;
    k->camera_from_world =
        SE3(rotation, scale * k->camera_from_world.translation() - (rotation * new_from_old.translation()));
    k->unit *= scale;
  }
}

void MapGraph::join(int from, int to, const Sim3& to_from_from, std::int64_t root, std::int64_t parent) {
  transform(from, to_from_from);
  make_root(root);
  for (const auto& k : keyframes_) {
    if (k && k->submap == from) k->submap = to;
  }
  set_parent(root, parent);
}

}  // namespace rastro
