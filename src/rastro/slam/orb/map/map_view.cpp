// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/map_view.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace rastro {
namespace {

std::vector<std::int64_t> keyframes_around(const MapGraph& graph, std::int64_t center, std::size_t most) {
  std::vector<std::int64_t> ids{center};
  std::vector<std::int64_t> sorted{center};
  const auto add = [&](std::int64_t id) {
    const auto at = std::lower_bound(sorted.begin(), sorted.end(), id);
    if (ids.size() >= most || (at != sorted.end() && *at == id)) return;
    sorted.insert(at, id);
    ids.push_back(id);
  };
  // Breadth first, until there are enough.
  for (std::size_t next = 0; next < ids.size() && ids.size() < most; ++next) {
    const std::size_t count = next == 0 ? most : 10;
    for (const Neighbor& n : graph.covisible(ids[next], next == 0 ? 1 : 15, count)) add(n.id);
    const MapKeyframe& keyframe = graph.keyframe(ids[next]);
    if (keyframe.parent >= 0) add(keyframe.parent);
  }
  return ids;
}

void add_keyframe(const MapGraph& graph, std::int64_t id, MapView& view) {
  const MapKeyframe& keyframe = graph.keyframe(id);
  // With depth, one keyframe makes a landmark.
  const std::size_t depth = graph.sensor() == CameraKind::mono ? 0 : 1;
  const std::size_t least = (graph.keyframe_count() > 2 ? 3 : 2) - depth;
  int solid = 0;
  for (const std::int64_t landmark : keyframe.landmarks) {
    if (landmark >= 0 && graph.landmark(landmark).observations.size() >= least) ++solid;
  }
  view.keyframes.push_back({id, keyframe.camera_from_world, keyframe.unit, keyframe.submap, solid, keyframe.frame});
}

/// Of the position, from its observations alone: the keyframes' poses count as certain.
Eigen::Matrix3d position_covariance(const MapGraph& graph, const MapLandmark& landmark) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const LandmarkObservation& o : landmark.observations) {
    const MapKeyframe& keyframe = graph.keyframe(o.keyframe);
    const Eigen::Vector3d p = keyframe.camera_from_world * landmark.position;
    const bool has_right = !std::isnan(keyframe.frame->right_pixel(o.feature));
    Eigen::Matrix3d jacobian;
    jacobian << 1.0, 0.0, -p.x() / p.z(), 0.0, 1.0, -p.y() / p.z(), 1.0, 0.0, (graph.baseline() - p.x()) / p.z();
    if (!has_right) jacobian.row(2).setZero();
    jacobian *= keyframe.camera_from_world.rotation().matrix() / (p.z() * graph.sigma(*keyframe.frame, o.feature));
    information += jacobian.transpose() * jacobian;
  }
  // A point at any distance: seen from one place only.
  const Eigen::Vector3d at =
      landmark.position -
      graph.keyframe(landmark.observations.front().keyframe).camera_from_world.inverse().translation();
  information += Eigen::Matrix3d::Identity() / at.squaredNorm();
  return information.inverse();
}

void add_landmark(const MapLandmark& landmark, MapView& view) {
  view.ids.push_back(landmark.id);
  view.positions.push_back(landmark.position);
  view.directions.push_back(landmark.direction);
  view.min_distances.push_back(landmark.min_distance);
  view.max_distances.push_back(landmark.max_distance);
  view.descriptors.push_back(landmark.descriptor);
  for (const LandmarkObservation& o : landmark.observations) {
    const std::int64_t at = view.find_keyframe(o.keyframe);
    if (at >= 0) view.seen_by.push_back(static_cast<std::uint32_t>(at));
  }
  view.seen_begin.push_back(static_cast<std::uint32_t>(view.seen_by.size()));
}

}  // namespace

std::int64_t MapView::find(std::int64_t landmark) const {
  const auto at = std::lower_bound(ids.begin(), ids.end(), landmark);
  return at != ids.end() && *at == landmark ? at - ids.begin() : -1;
}

std::int64_t MapView::find_keyframe(std::int64_t id) const {
  const auto at = std::lower_bound(keyframes.begin(), keyframes.end(), id,
                                   [](const Keyframe& keyframe, std::int64_t wanted) { return keyframe.id < wanted; });
  return at != keyframes.end() && at->id == id ? at - keyframes.begin() : -1;
}

std::shared_ptr<const MapView> view_of(const MapGraph& graph, std::int64_t center, const MapViewOptions& options) {
  auto view = std::make_shared<MapView>();
  view->center = center;
  view->latest = graph.newest_keyframe();
  std::vector<std::int64_t> ids = keyframes_around(graph, center, static_cast<std::size_t>(options.keyframes));
  std::vector<std::int64_t> landmarks;
  for (const std::int64_t id : ids) {
    if (landmarks.size() > 4 * static_cast<std::size_t>(options.landmarks)) break;
    for (const std::int64_t landmark : graph.keyframe(id).landmarks) {
      if (landmark >= 0) landmarks.push_back(landmark);
    }
  }
  std::sort(landmarks.begin(), landmarks.end());
  landmarks.erase(std::unique(landmarks.begin(), landmarks.end()), landmarks.end());
  // Of too many, keep the newest: they are the local ones.
  if (landmarks.size() > static_cast<std::size_t>(options.landmarks))
    landmarks.erase(landmarks.begin(), landmarks.end() - options.landmarks);
  std::sort(ids.begin(), ids.end());
  for (const std::int64_t id : ids) add_keyframe(graph, id, *view);
  view->seen_begin.push_back(0);
  for (const std::int64_t id : landmarks) add_landmark(graph.landmark(id), *view);
  if (options.covariances) {
    for (const std::int64_t id : landmarks) view->covariances.push_back(position_covariance(graph, graph.landmark(id)));
  }
  return view;
}

}  // namespace rastro
