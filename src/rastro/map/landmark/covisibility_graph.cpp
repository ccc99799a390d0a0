// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/map/landmark/essential_graph.h"
#include "rastro/map/landmark/keyframe_places.h"
#include "rastro/map/landmark/landmark_map.h"

namespace rastro {
namespace {

/// For each keyframe, the places of the landmarks that it sees.
using SeenLandmarks = std::vector<std::vector<std::uint32_t>>;

/// For each landmark, the places of the keyframes that see it, ascending.
std::vector<std::vector<std::uint32_t>> viewers_of(const LandmarkMap& map, const KeyframePlaces& places) {
  std::vector<std::vector<std::uint32_t>> viewers(map.landmarks.size());
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    for (const LandmarkObservation& observation : map.landmarks[i].observations) {
      const auto place = places.of(observation.keyframe);
      RASTRO_CHECK(place.has_value(), "a landmark is seen by keyframes of its map");
      viewers[i].push_back(static_cast<std::uint32_t>(*place));
    }
  }
  return viewers;
}

}  // namespace

std::vector<Covisibility> covisibility_graph(const LandmarkMap& map, int least) {
  const auto viewers = viewers_of(map, KeyframePlaces(map));
  SeenLandmarks seen(map.keyframes.size());
  for (std::size_t i = 0; i < viewers.size(); ++i)
    for (const std::uint32_t keyframe : viewers[i]) seen[keyframe].push_back(static_cast<std::uint32_t>(i));
  std::vector<Covisibility> graph;
  std::vector<int> shared(map.keyframes.size());
  for (std::size_t first = 0; first < seen.size(); ++first) {
    std::fill(shared.begin(), shared.end(), 0);
    for (const std::uint32_t landmark : seen[first])
      for (const std::uint32_t second : viewers[landmark]) ++shared[second];
    for (std::size_t second = first + 1; second < seen.size(); ++second)
      if (shared[second] >= std::max(least, 1))
        graph.push_back({static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(second), shared[second]});
  }
  return graph;
}

std::vector<EssentialEdge> essential_graph(const LandmarkMap& map, int strong) {
  const KeyframePlaces places(map);
  std::vector<EssentialEdge> graph;
  const auto add = [&graph](std::size_t a, std::size_t b, EssentialKind kind, int shared) {
    if (a == b) return;
    const auto from = static_cast<std::uint32_t>(std::min(a, b)), to = static_cast<std::uint32_t>(std::max(a, b));
    graph.push_back({from, to, kind, shared});
  };
  for (const LandmarkTie& tie : map.ties) {
    const auto from = places.of(tie.from), to = places.of(tie.to);
    if (from && to) add(*from, *to, EssentialKind::tie, tie.inliers);
  }
  const std::vector<Covisibility> covisible = covisibility_graph(map, 1);
  for (std::size_t k = 0; k < map.poses.size(); ++k) {
    const auto parent = map.poses[k].parent < 0 ? std::nullopt : places.of(map.poses[k].parent);
    if (parent) add(k, *parent, EssentialKind::tree, 0);
  }
  for (const Covisibility& pair : covisible)
    if (pair.shared >= strong) add(pair.first, pair.second, EssentialKind::covisible, pair.shared);
  const auto key = [](const EssentialEdge& edge) { return std::tuple(edge.first, edge.second, edge.kind); };
  std::sort(graph.begin(), graph.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  const auto same_pair = [](const EssentialEdge& a, const EssentialEdge& b) {
    return a.first == b.first && a.second == b.second;
  };
  graph.erase(std::unique(graph.begin(), graph.end(), same_pair), graph.end());
  for (EssentialEdge& edge : graph) {
    if (edge.kind != EssentialKind::tree) continue;
    const auto found = std::lower_bound(
        covisible.begin(), covisible.end(), edge, [](const Covisibility& pair, const EssentialEdge& wanted) {
          return std::pair(pair.first, pair.second) < std::pair(wanted.first, wanted.second);
        });
    if (found != covisible.end() && found->first == edge.first && found->second == edge.second)
      edge.shared = found->shared;
  }
  return graph;
}

}  // namespace rastro
