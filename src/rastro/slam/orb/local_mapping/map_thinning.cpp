// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/local_mapping/map_thinning.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

namespace rastro {

Redundancy redundancy_of(const MapGraph& graph, const MapKeyframe& keyframe, const OrbSlamOptions& options) {
  Redundancy counted;
  const double far = options.far_baselines * graph.baseline();
  for (std::size_t i = 0; i < keyframe.landmarks.size(); ++i) {
    if (keyframe.landmarks[i] < 0) continue;
    if (graph.sensor() != CameraKind::mono && !(static_cast<double>(keyframe.frame->data().depths[i]) <= far)) continue;
    const MapLandmark& landmark = graph.landmark(keyframe.landmarks[i]);
    ++counted.landmarks;
    if (landmark.observations.size() <= 3) continue;
    const int level = keyframe.frame->level(i);
    int others = 0;
    for (const LandmarkObservation& o : landmark.observations) {
      if (o.keyframe != keyframe.id && graph.keyframe(o.keyframe).frame->level(o.feature) <= level + 1) ++others;
    }
    if (others >= 3) ++counted.redundant;
  }
  return counted;
}

/// A feature takes its descriptor and depth, its grid entry, its landmark and its word.
std::size_t MapThinning::graph_bytes() const {
  constexpr std::size_t a_feature = sizeof(Keypoint) + sizeof(Descriptor) + sizeof(float) + sizeof(std::uint8_t) +
                                    sizeof(Eigen::Vector2f) + 2 * sizeof(float) + sizeof(std::int64_t) +
                                    3 * sizeof(std::uint32_t);
  std::size_t features = 0, observations = 0, neighbors = 0;
  const std::vector<std::int64_t> ids = graph_.keyframe_ids();
  for (const std::int64_t id : ids) {
    const MapKeyframe& keyframe = graph_.keyframe(id);
    features += keyframe.landmarks.size();
    neighbors += keyframe.neighbors.size();
    observations += static_cast<std::size_t>(
        std::count_if(keyframe.landmarks.begin(), keyframe.landmarks.end(), [](std::int64_t l) { return l >= 0; }));
  }
  return ids.size() * sizeof(MapKeyframe) + features * a_feature + neighbors * sizeof(Neighbor) +
         graph_.landmark_count() * sizeof(MapLandmark) + observations * sizeof(LandmarkObservation) +
         graph_.constraints().size() * sizeof(Constraint);
}

void MapThinning::process(std::size_t trajectory_bytes, std::vector<SlamEvent>& events) {
  if (!limited()) return;
  const std::size_t bytes = graph_bytes() + trajectory_bytes;
  const bool new_stage = budget_.note(bytes);
  const bool thinned = bytes > budget_.full_bytes() && remove_redundant(trajectory_bytes);
  if (new_stage || thinned) events.push_back(budget_.event(graph_bytes() + trajectory_bytes, measures()));
}

bool MapThinning::remove_redundant(std::size_t trajectory_bytes) {
  constexpr double least_share = 0.5;
  std::vector<std::pair<double, std::int64_t>> order;  // the most redundant first, the oldest of equals
  for (const std::int64_t id : removable())
    order.emplace_back(-redundancy_of(graph_, graph_.keyframe(id), options_).share(), id);
  std::sort(order.begin(), order.end());
  const int before = removed_;
  for (const auto& [minus_share, id] : order) {
    const std::size_t bytes = graph_bytes() + trajectory_bytes;
    if (bytes <= (-minus_share >= least_share ? budget_.full_bytes() : budget_.bytes())) break;
    graph_.remove_keyframe(id);
    ++removed_;
  }
  return removed_ > before;
}

std::vector<std::int64_t> MapThinning::removable() const {
  constexpr std::size_t newest_kept = 10;
  std::set<std::int64_t> constrained;
  for (const Constraint& constraint : graph_.constraints()) constrained.insert({constraint.from, constraint.to});
  std::vector<std::int64_t> ids = graph_.keyframe_ids();
  ids.resize(ids.size() - std::min(ids.size(), newest_kept));
  std::erase_if(ids, [&](std::int64_t id) { return graph_.keyframe(id).parent < 0 || constrained.contains(id); });
  return ids;
}

std::string MapThinning::measures() const {
  std::string text;
  if (budget_.stage() > 0) text = fmt::format("keyframes {:g} times as sparse", budget_.spacing());
  if (budget_.stage() > 1) text += ", no observations of frames";
  if (removed_ > 0) text += fmt::format(", {} keyframes removed", removed_);
  return text;
}

MapMemory MapThinning::memory(std::size_t trajectory_bytes) const {
  return {graph_bytes() + trajectory_bytes, budget_.bytes(), measures()};
}

}  // namespace rastro
