// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/graph/covisibility.h"

#include <algorithm>
#include <tuple>

#include "rastro/base/error.h"
#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {
namespace {

/// For each landmark, the indices of the keyframes that observe it, ascending.
std::vector<std::vector<std::uint32_t>> observers_of(const Map& map, const LandmarkLayer& layer) {
  std::vector<std::vector<std::uint32_t>> observers(layer.landmarks.size());
  for (std::size_t i = 0; i < layer.landmarks.size(); ++i) {
    for (const LandmarkObservation& observation : layer.landmarks[i].observations) {
      const auto index = map.index_of(observation.keyframe);
      RASTRO_CHECK(index.has_value(), "a landmark is observed by keyframes of its map");
      observers[i].push_back(static_cast<std::uint32_t>(*index));
    }
  }
  return observers;
}

}  // namespace

std::vector<Covisibility> covisibility_graph(const Map& map, int least) {
  const auto layer = map.layer<LandmarkLayer>();
  if (!layer) return {};
  const auto observers = observers_of(map, *layer);
  std::vector<std::vector<std::uint32_t>> observed(map.keyframes.size());
  for (std::size_t i = 0; i < observers.size(); ++i)
    for (const std::uint32_t keyframe : observers[i]) observed[keyframe].push_back(static_cast<std::uint32_t>(i));
  std::vector<Covisibility> graph;
  std::vector<int> shared(map.keyframes.size());
  for (std::size_t first = 0; first < observed.size(); ++first) {
    std::fill(shared.begin(), shared.end(), 0);
    for (const std::uint32_t landmark : observed[first])
      for (const std::uint32_t second : observers[landmark]) ++shared[second];
    for (std::size_t second = first + 1; second < observed.size(); ++second)
      if (shared[second] >= std::max(least, 1))
        graph.push_back({static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(second), shared[second]});
  }
  return graph;
}

std::vector<EssentialEdge> essential_graph(const Map& map, int strong) {
  std::vector<EssentialEdge> graph;
  const auto add = [&graph](std::size_t a, std::size_t b, EssentialKind kind, int shared) {
    if (a == b) return;
    const auto from = static_cast<std::uint32_t>(std::min(a, b)), to = static_cast<std::uint32_t>(std::max(a, b));
    graph.push_back({from, to, kind, shared});
  };
  for (const Constraint& constraint : map.constraints) {
    if (constraint.kind != ConstraintKind::loop && constraint.kind != ConstraintKind::merge) continue;
    const auto from = map.index_of(constraint.from), to = map.index_of(constraint.to);
    if (from && to) add(*from, *to, EssentialKind::constraint, constraint.inliers);
  }
  const std::vector<Covisibility> covisible = covisibility_graph(map, 1);
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    const auto parent = map.index_of(map.keyframes[k].parent);
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
