// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/map_graph.h"

#include <algorithm>

#include "rastro/base/error.h"

namespace rastro {
namespace {

void insert_sorted(std::vector<std::int64_t>& ids, std::int64_t id) {
  ids.insert(std::lower_bound(ids.begin(), ids.end(), id), id);
}

void erase_sorted(std::vector<std::int64_t>& ids, std::int64_t id) {
  const auto at = std::lower_bound(ids.begin(), ids.end(), id);
  if (at != ids.end() && *at == id) ids.erase(at);
}

/// For those kept by id.
constexpr auto is_before = [](std::int64_t id, const auto& kept) { return id < kept.first; };

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
  const Removed kept{gone.parent, PackedSE3(gone.camera_from_world * parent.camera_from_world.inverse()), parent.unit,
                     gone.unit};
  removed_.emplace(std::upper_bound(removed_.begin(), removed_.end(), id, is_before), id, kept);
  newly_removed_.push_back(id);
  const std::size_t least = sensor_ == CameraKind::mono ? 2 : 1;
  const std::vector<std::int64_t> seen = gone.landmarks;
  for (const std::int64_t landmark_id : seen) {
    if (landmark_id < 0) continue;
    remove_observation(id, landmark_id);
    if (landmark(landmark_id).observations.size() < least) remove_landmark(landmark_id);
  }
  move_children(gone);
  erase_sorted(keyframe(gone.parent).children, id);
  std::erase_if(constraints_,
                [&](const Constraint& constraint) { return constraint.from == id || constraint.to == id; });
  std::erase_if(direct_poses_, [&](const DirectPose& direct) { return direct.keyframe == id || direct.camera == id; });
  keyframes_[static_cast<std::size_t>(id)].reset();
  --keyframe_count_;
}

/// Children go to the parent of the removed keyframe, or to a sibling with a new parent: whichever shares most.
void MapGraph::move_children(const MapKeyframe& gone) {
  std::vector<std::int64_t> in_tree{gone.parent}, left = gone.children;
  while (!left.empty()) {
    std::int64_t best_child = left.front(), best_parent = in_tree.front();
    int best = -1;
    for (const std::int64_t child : left) {
      for (const std::int64_t candidate : in_tree) {
        const int count = shared(child, candidate);
        if (count > best) {
          best = count;
          best_child = child;
          best_parent = candidate;
        }
      }
    }
    set_parent(best_child, best_parent);
    in_tree.push_back(best_child);
    std::erase(left, best_child);
  }
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

const MapGraph::Removed& MapGraph::removed(std::int64_t id) const {
  const auto after = std::upper_bound(removed_.begin(), removed_.end(), id, is_before);
  RASTRO_CHECK(after != removed_.begin() && std::prev(after)->first == id, "never a keyframe");
  return std::prev(after)->second;
}

SE3 MapGraph::camera_from_world(std::int64_t id) const {
  if (has_keyframe(id)) return keyframe(id).camera_from_world;
  const Removed& gone = removed(id);
  return scaled(gone.keyframe_from_parent.pose(), unit(gone.parent) / gone.parent_unit) *
         camera_from_world(gone.parent);
}

double MapGraph::unit(std::int64_t id) const {
  if (has_keyframe(id)) return keyframe(id).unit;
  const Removed& gone = removed(id);
  return gone.unit * unit(gone.parent) / gone.parent_unit;
}

int MapGraph::submap(std::int64_t id) const {
  return has_keyframe(id) ? keyframe(id).submap : submap(removed(id).parent);
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
  landmarks_.for_each([&](MapLandmark& l) {
    if (l.observations.empty() || keyframe(l.observations.front().keyframe).submap != submap) return;
    l.position = new_from_old * l.position;
    l.direction = new_from_old.rotation() * l.direction;
    l.min_distance *= static_cast<float>(scale);
    l.max_distance *= static_cast<float>(scale);
  });
  const SO3 old_from_new = new_from_old.rotation().inverse();
  for (const auto& k : keyframes_) {
    if (!k || k->submap != submap) continue;
    const SO3 rotation = k->camera_from_world.rotation() * old_from_new;
    k->camera_from_world =
        SE3(rotation, scale * k->camera_from_world.translation() - (rotation * new_from_old.translation()));
    k->unit *= scale;
  }
}

void MapGraph::merge(int from, int to, const Sim3& to_from_from, std::int64_t root, std::int64_t parent) {
  transform(from, to_from_from);
  make_root(root);
  for (const auto& k : keyframes_) {
    if (k && k->submap == from) k->submap = to;
  }
  set_parent(root, parent);
}

}  // namespace rastro
