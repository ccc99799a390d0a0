// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/map_export.h"

#include <map>

namespace rastro {
namespace {

MapScale scale_of(LandmarkSensor sensor) {
  if (sensor == LandmarkSensor::stereo) return {true, 0.0, "stereo baseline"};
  if (sensor == LandmarkSensor::rgbd) return {true, 0.0, "depth camera"};
  return {false, 0.0, "arbitrary"};
}

Landmark public_form(const MapLandmark& landmark) {
  return {landmark.id,           landmark.position,     landmark.direction,   landmark.descriptor,
          landmark.min_distance, landmark.max_distance, landmark.observations};
}

}  // namespace

std::shared_ptr<const LandmarkMap> landmark_map_of(const MapGraph& graph, const FrameTrajectory& trajectory,
                                                   const std::optional<MapScale>& scale) {
  auto map = std::make_shared<LandmarkMap>();
  map->method = "orb";
  map->sensor = graph.sensor();
  map->camera = graph.camera();
  map->baseline = graph.sensor() == LandmarkSensor::stereo ? graph.baseline() : 0.0;
  map->scale = scale ? *scale : scale_of(graph.sensor());
  map->features = graph.orb_options();
  const int largest = trajectory.largest_submap(graph);
  for (const std::int64_t id : graph.keyframe_ids()) {
    const MapKeyframe& keyframe = graph.keyframe(id);
    const int submap = keyframe.submap == largest  ? 0
                       : keyframe.submap < largest ? keyframe.submap + 1
                                                   : keyframe.submap;
    map->keyframes.push_back(keyframe.frame->shared_data());
    map->poses.push_back({keyframe.camera_from_world.inverse(), submap, keyframe.parent});
  }
  for (const std::int64_t id : graph.landmark_ids()) {
    if (!graph.landmark(id).observations.empty()) map->landmarks.push_back(public_form(graph.landmark(id)));
  }
  map->ties = graph.ties();
  map->trajectory = trajectory.trajectory(graph, largest);
  return map;
}

std::shared_ptr<const Snapshot> snapshot_of(const MapGraph& graph, const FrameTrajectory& trajectory,
                                            const std::optional<MapScale>& scale) {
  auto snapshot = std::make_shared<Snapshot>();
  auto map = landmark_map_of(graph, trajectory, scale);
  snapshot->revision = map->keyframes.empty() ? 0 : map->keyframes.back()->id + 1;
  std::map<std::int64_t, std::size_t> place;
  for (std::size_t i = 0; i < map->keyframes.size(); ++i) {
    if (map->poses[i].submap != 0) continue;
    place[map->keyframes[i]->id] = snapshot->keyframes.size();
    snapshot->keyframes.push_back({map->keyframes[i]->stamp, map->poses[i].world_from_camera});
  }
  for (std::size_t i = 0; i < map->keyframes.size(); ++i) {
    const auto child = place.find(map->keyframes[i]->id), parent = place.find(map->poses[i].parent);
    if (child != place.end() && parent != place.end())
      snapshot->edges.push_back({parent->second, child->second, false});
  }
  for (const LandmarkTie& tie : map->ties) {
    const auto from = place.find(tie.from), to = place.find(tie.to);
    if (from != place.end() && to != place.end()) snapshot->edges.push_back({from->second, to->second, true});
  }
  snapshot->landmark_map = std::move(map);
  return snapshot;
}

void restore(const LandmarkMap& map, double baseline, MapGraph& graph) {
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    auto frame = std::make_shared<FeatureFrame>(map.keyframes[i], graph.camera(), baseline);
    graph.add_keyframe(std::move(frame), map.poses[i].world_from_camera.inverse(), map.poses[i].submap, -1);
  }
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) graph.set_parent(map.keyframes[i]->id, map.poses[i].parent);
  for (const Landmark& landmark : map.landmarks) graph.restore_landmark(landmark);
  graph.ties() = map.ties;
}

}  // namespace rastro
