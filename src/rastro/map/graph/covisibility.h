// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "rastro/map/graph/map.h"

namespace rastro {

/// Number of landmarks two keyframes share. Indices into map.keyframes, first < second.
struct Covisibility {
  std::uint32_t first = 0, second = 0;
  int shared = 0;
};

/// For all pairs that share at least `least` landmarks, ordered; Mur-Artal et al. 2015, section III.D. Empty for a map
/// without landmarks.
std::vector<Covisibility> covisibility_graph(const Map& map, int least);

/// In order of precedence where a pair of keyframes has several.
enum class EssentialKind : std::uint8_t {
  constraint,  ///< Loop closure or merge.
  tree,        ///< To the parent in the spanning tree.
  covisible,   ///< Many landmarks shared.
};

/// Indices into map.keyframes, first < second.
struct EssentialEdge {
  std::uint32_t first = 0, second = 0;
  EssentialKind kind = EssentialKind::tree;
  int shared = 0;  ///< Landmarks; inliers of a constraint.
};

/// Spanning tree, loop closures and merges, and pairs of keyframes that share at least `strong` landmarks: Mur-Artal et
/// al. 2015, section III.D. Ordered, each pair once.
std::vector<EssentialEdge> essential_graph(const Map& map, int strong = 100);

}  // namespace rastro
