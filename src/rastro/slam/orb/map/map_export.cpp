// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/map_export.h"

#include <algorithm>
#include <vector>

#include "rastro/map/features/feature_layer.h"
#include "rastro/map/graph/edit.h"
#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {
namespace {

MapScale scale_of(CameraKind sensor) {
  if (sensor == CameraKind::stereo) return {true, 0.0, "stereo baseline"};
  if (sensor == CameraKind::depth) return {true, 0.0, "depth camera"};
  return {false, 0.0, "arbitrary"};
}

Landmark public_form(const MapLandmark& landmark) {
  return {landmark.id,           landmark.position,     landmark.direction,   landmark.descriptor,
          landmark.min_distance, landmark.max_distance, landmark.observations};
}

/// Renumbers the submap with most frames to 0.
int public_submap(int submap, int largest) { return submap == largest ? 0 : submap < largest ? submap + 1 : submap; }

void add_keyframes(const MapGraph& graph, int largest, Map& map) {
  auto features = std::make_shared<FeatureLayer>();
  features->extraction = graph.orb_options();
  for (const std::int64_t id : graph.keyframe_ids()) {
    const MapKeyframe& keyframe = graph.keyframe(id);
    const ImageFeatures& image = keyframe.frame->data();
    map.keyframes.push_back({id, image.frame, image.stamp, 0, keyframe.camera_from_world.inverse(),
                             public_submap(keyframe.submap, largest), keyframe.parent, 1.0});
    features->of[id] = keyframe.frame->shared_data();
  }
  map.layers.put<FeatureLayer>(std::move(features));
}

void add_landmarks(const MapGraph& graph, Map& map) {
  auto layer = std::make_shared<LandmarkLayer>();
  for (const std::int64_t id : graph.landmark_ids())
    if (!graph.landmark(id).observations.empty()) layer->landmarks.push_back(public_form(graph.landmark(id)));
  map.layers.put<LandmarkLayer>(std::move(layer));
}

/// Re-references frames of culled keyframes to the nearest earlier keyframe of the submap.
class FrameReferences {
 public:
  explicit FrameReferences(const Map& map) : map_(map) {
    for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
      const auto submap = static_cast<std::size_t>(map.keyframes[k].submap);
      if (submap >= by_stamp_.size()) by_stamp_.resize(submap + 1);
      by_stamp_[submap].push_back(k);
    }
    for (auto& keyframes : by_stamp_)
      std::stable_sort(keyframes.begin(), keyframes.end(),
                       [&](std::size_t a, std::size_t b) { return map.keyframes[a].stamp < map.keyframes[b].stamp; });
  }

  const Keyframe* of(TimeNs stamp, int submap) const {
    if (static_cast<std::size_t>(submap) >= by_stamp_.size()) return nullptr;
    const auto& keyframes = by_stamp_[static_cast<std::size_t>(submap)];
    const auto after = std::upper_bound(keyframes.begin(), keyframes.end(), stamp,
                                        [&](TimeNs wanted, std::size_t k) { return wanted < map_.keyframes[k].stamp; });
    if (keyframes.empty()) return nullptr;
    return &map_.keyframes[after == keyframes.begin() ? *after : *(after - 1)];
  }

 private:
  const Map& map_;
  std::vector<std::vector<std::size_t>> by_stamp_;  ///< Indices of keyframes, by submap.
};

void add_frames(const MapGraph& graph, const FrameTrajectory& trajectory, int largest, Map& map) {
  const FrameReferences references(map);
  map.frames.reserve(map.frames.size() + trajectory.frames().size());
  for (const auto& frame : trajectory.frames()) {
    const double scale = graph.unit(frame.keyframe) / frame.unit;
    const SE3 camera_from_keyframe(frame.camera_from_keyframe.rotation(),
                                   scale * frame.camera_from_keyframe.translation());
    if (graph.has_keyframe(frame.keyframe)) {
      map.frames.push_back({frame.stamp, frame.keyframe, camera_from_keyframe.inverse()});
      continue;
    }
    const SE3 world_from_camera = (camera_from_keyframe * graph.camera_from_world(frame.keyframe)).inverse();
    const Keyframe* reference = references.of(frame.stamp, public_submap(graph.submap(frame.keyframe), largest));
    if (reference)
      map.frames.push_back({frame.stamp, reference->id, reference->world_from_camera.inverse() * world_from_camera});
  }
}

/// Those of the given map and this one, which has the unit of its sensor or of the given map.
void add_sessions(const FrameTrajectory& trajectory, const std::optional<GivenMap>& given, Map& map) {
  if (given) map.sessions = given->sessions;
  MapSession now;
  now.scale = given ? given->scale : scale_of(map.cameras.front().kind);
  if (!map.sessions.empty()) {
    now.session = map.sessions.back().session + 1;
    if (trajectory.frames().empty()) return;
    now.first_stamp = trajectory.frames().front().stamp, now.last_stamp = trajectory.frames().back().stamp;
  } else if (!map.frames.empty()) {
    now.first_stamp = map.frames.front().stamp, now.last_stamp = map.frames.back().stamp;
  }
  map.sessions.push_back(now);
}

}  // namespace

std::shared_ptr<const Map> map_of(const MapGraph& graph, const FrameTrajectory& trajectory,
                                  const std::optional<GivenMap>& given, const std::string& method) {
  auto map = std::make_shared<Map>();
  map->method = method;
  map->revision = graph.newest_keyframe() + 1;
  const double baseline = graph.sensor() == CameraKind::stereo ? graph.baseline() : 0.0;
  map->cameras.push_back({graph.sensor(), graph.camera(), baseline, {}, SE3()});
  const int largest = given ? 0 : trajectory.largest_submap(graph);
  add_keyframes(graph, largest, *map);
  add_landmarks(graph, *map);
  map->constraints = graph.constraints();
  if (given) add_frames(graph, given->trajectory, largest, *map);
  add_frames(graph, trajectory, largest, *map);
  add_sessions(trajectory, given, *map);
  return map;
}

GivenMap restore(const Map& given, double baseline, MapGraph& graph) {
  constexpr KeyframeId most_spread = 1 << 24;  // the graph has an entry for each number
  const bool spread = !given.keyframes.empty() && given.keyframes.back().id >= most_spread;
  const Map map = spread ? renumbered(given) : given;
  const auto features = map.layer<FeatureLayer>();
  for (const Keyframe& keyframe : map.keyframes) {
    auto frame = std::make_shared<FeatureFrame>(features->of.at(keyframe.id), graph.camera(), baseline);
    graph.add_keyframe(std::move(frame), keyframe.world_from_camera.inverse(), keyframe.submap, -1);
  }
  for (const Keyframe& keyframe : map.keyframes) graph.set_parent(keyframe.id, keyframe.parent);
  for (const Landmark& landmark : map.layer<LandmarkLayer>()->landmarks) graph.restore_landmark(landmark);
  graph.constraints() = map.constraints;
  GivenMap restored{scale_of(map), {}, map.sessions};
  for (std::size_t k = 0; k < map.frames.size(); ++k)
    restored.trajectory.add({static_cast<std::int64_t>(k),
                             map.frames[k].stamp,
                             map.frames[k].keyframe,
                             1.0,
                             map.frames[k].keyframe_from_camera.inverse(),
                             -1,
                             {}});
  return restored;
}

}  // namespace rastro
