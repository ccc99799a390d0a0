// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>

#include "rastro/base/error.h"
#include "rastro/feature/hamming.h"
#include "rastro/slam/orb/map/map_graph.h"

namespace rastro {
namespace {

auto insertion_point(std::vector<LandmarkObservation>& observations, std::int64_t keyframe) {
  return std::lower_bound(observations.begin(), observations.end(), keyframe,
                          [](const LandmarkObservation& o, std::int64_t id) { return o.keyframe < id; });
}

}  // namespace

MapLandmark& MapGraph::add_landmark(const Eigen::Vector3d& position, std::int64_t keyframe) {
  return add_landmark(landmarks_.end_id(), position, keyframe);
}

MapLandmark& MapGraph::add_landmark(std::int64_t id, const Eigen::Vector3d& position, std::int64_t keyframe) {
  auto landmark = std::make_unique<MapLandmark>();
  landmark->id = id;
  landmark->position = position;
  landmark->first_keyframe = keyframe;
  ++landmark_count_;
  return landmarks_.add(id, std::move(landmark));
}

void MapGraph::restore_landmark(const Landmark& landmark) {
  RASTRO_CHECK(landmark.id >= landmarks_.end_id(), "ids of landmarks ascend");
  MapLandmark& restored = add_landmark(landmark.id, landmark.position,
                                       landmark.observations.empty() ? -1 : landmark.observations.front().keyframe);
  restored.direction = landmark.direction;
  restored.descriptor = landmark.descriptor;
  restored.min_distance = landmark.min_distance;
  restored.max_distance = landmark.max_distance;
  for (const LandmarkObservation& o : landmark.observations) add_observation(o.keyframe, o.feature, restored.id);
}

bool MapGraph::has_landmark(std::int64_t id) const { return landmarks_.find(id) != nullptr; }

MapLandmark& MapGraph::landmark(std::int64_t id) {
  MapLandmark* const found = landmarks_.find(id);
  RASTRO_CHECK(found != nullptr, "the landmark exists");
  return *found;
}

const MapLandmark& MapGraph::landmark(std::int64_t id) const {
  MapLandmark* const found = landmarks_.find(id);
  RASTRO_CHECK(found != nullptr, "the landmark exists");
  return *found;
}

std::int64_t MapGraph::current(std::int64_t id) const {
  while (id >= 0 && !has_landmark(id)) id = fused_.kept_of(id);
  return id;
}

std::vector<std::int64_t> MapGraph::landmark_ids() const {
  std::vector<std::int64_t> ids;
  landmarks_.for_each([&](const MapLandmark& landmark) { ids.push_back(landmark.id); });
  return ids;
}

void MapGraph::remove_landmark(std::int64_t id) {
  MapLandmark& gone = landmark(id);
  while (!gone.observations.empty()) remove_observation(gone.observations.back().keyframe, id);
  landmarks_.remove(id);
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
  fused_.add(gone, kept);
  describe(kept);
}

void MapGraph::add_observation(std::int64_t keyframe, std::uint32_t feature, std::int64_t landmark) {
  MapKeyframe& observer = this->keyframe(keyframe);
  MapLandmark& seen = this->landmark(landmark);
  const auto at = insertion_point(seen.observations, keyframe);
  if (observer.landmarks[feature] >= 0 || (at != seen.observations.end() && at->keyframe == keyframe)) return;
  for (const LandmarkObservation& other : seen.observations) count(keyframe, other.keyframe, 1);
  seen.observations.insert(at, {keyframe, feature});
  observer.landmarks[feature] = landmark;
}

void MapGraph::remove_observation(std::int64_t keyframe, std::int64_t landmark) {
  MapLandmark& seen = this->landmark(landmark);
  const auto at = insertion_point(seen.observations, keyframe);
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

}  // namespace rastro
