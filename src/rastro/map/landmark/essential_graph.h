// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "rastro/map/landmark/landmark_map.h"

namespace rastro {

/// In the order in which one goes before another where a pair of keyframes has several.
enum class EssentialKind : std::uint8_t {
  tie,        ///< Loop closing or joining.
  tree,       ///< To the parent in the spanning tree.
  covisible,  ///< Many landmarks shared.
};

/// Indices into map.keyframes, first < second.
struct EssentialEdge {
  std::uint32_t first = 0, second = 0;
  EssentialKind kind = EssentialKind::tree;
  int shared = 0;  ///< Landmarks; inliers of a tie.
};

/// Spanning tree, ties, and pairs of keyframes that share at least `strong` landmarks: Mur-Artal et al. 2015, section
/// III.D. Ordered, each pair once.
std::vector<EssentialEdge> essential_graph(const LandmarkMap& map, int strong = 100);

}  // namespace rastro
