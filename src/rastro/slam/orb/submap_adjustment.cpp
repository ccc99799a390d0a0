// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/submap_adjustment.h"

#include <fmt/format.h>

#include <map>
#include <set>

namespace rastro {
namespace {

BundleParts parts_of(const MapGraph& graph, int submap, double pixel_sigma) {
  std::vector<std::int64_t> free, fixed;
  for (const std::int64_t id : graph.keyframe_ids(submap)) (graph.keyframe(id).parent < 0 ? fixed : free).push_back(id);
  return bundle_parts(graph, free, fixed, pixel_sigma);
}

/// How the world moves around each keyframe: new_world_from_old_world.
class Moves {
 public:
  Moves(const MapGraph& graph, const BundleParts& parts) : graph_(graph) {
    for (std::size_t i = 0; i < parts.keyframes.size(); ++i) {
      const std::int64_t id = parts.keyframes[i];
      if (graph.has_keyframe(id))
        moves_.emplace(id, parts.bundle.camera_from_world[i].inverse() * graph.keyframe(id).camera_from_world);
    }
  }

  /// Its own or that of its nearest adjusted ancestor.
  SE3 of(std::int64_t keyframe) const {
    for (std::int64_t id = keyframe; id >= 0; id = graph_.keyframe(id).parent) {
      const auto at = moves_.find(id);
      if (at != moves_.end()) return at->second;
    }
    return {};
  }

 private:
  const MapGraph& graph_;
  std::map<std::int64_t, SE3> moves_;
};

}  // namespace

SubmapAdjustment::SubmapAdjustment(const MapGraph& graph, int submap, double pixel_sigma)
    : parts_(parts_of(graph, submap, pixel_sigma)) {}

void SubmapAdjustment::run(int iterations, const std::atomic<bool>* stop, TaskPool* pool) {
  if (parts_.bundle.observations.empty()) return;
  const auto stopped = [&] { return cancelled_.load() || (stop != nullptr && stop->load()); };
  adjust_parts(parts_, iterations, stopped, pool);
}

void SubmapAdjustment::apply(MapGraph& graph) const {
  const Moves moves(graph, parts_);
  std::map<std::int64_t, SE3> moved;
  std::set<int> submaps;
  for (const std::int64_t id : parts_.keyframes) {
    if (graph.has_keyframe(id)) submaps.insert(graph.keyframe(id).submap);
  }
  for (const int submap : submaps) {
    for (const std::int64_t id : graph.keyframe_ids(submap)) moved.emplace(id, moves.of(id));
  }
  for (std::size_t i = 0; i < parts_.landmarks.size(); ++i) {
    if (graph.has_landmark(parts_.landmarks[i])) graph.landmark(parts_.landmarks[i]).position = parts_.bundle.points[i];
  }
  const std::set<std::int64_t> adjusted(parts_.landmarks.begin(), parts_.landmarks.end());
  for (const std::int64_t id : graph.landmark_ids()) {
    MapLandmark& landmark = graph.landmark(id);
    if (landmark.observations.empty() || adjusted.contains(id)) continue;
    auto with = moved.find(landmark.first_keyframe);
    if (with == moved.end()) with = moved.find(landmark.observations.front().keyframe);
    if (with != moved.end()) landmark.position = with->second * landmark.position;
  }
  for (const auto& [id, move] : moved) {
    MapKeyframe& keyframe = graph.keyframe(id);
    keyframe.camera_from_world = keyframe.camera_from_world * move.inverse();
  }
  drop_outliers(graph, parts_);
}

std::string SubmapAdjustment::detail() const {
  return fmt::format("{} keyframes, {} landmarks, {} of {} observations taken out", parts_.keyframes.size(),
                     parts_.landmarks.size(), parts_.outliers.size(), parts_.outliers.size() + parts_.seen.size());
}

}  // namespace rastro
