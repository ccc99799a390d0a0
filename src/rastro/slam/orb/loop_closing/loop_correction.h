// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "rastro/math/sim3.h"
#include "rastro/slam/orb/map/map_graph.h"
#include "rastro/slam/orb/options.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// A keyframe that shows the place of another.
struct VerifiedLoop {
  std::int64_t keyframe = 0, matched = 0;
  Sim3 keyframe_from_matched;  ///< Camera frames, each in the unit it now has.
  int inliers = 0;             ///< Pairs of landmarks that fit it.
  /// Features of the keyframe and the landmarks of the place that they show.
  std::vector<std::pair<std::uint32_t, std::int64_t>> landmarks;
};

/// What the map made of a place that was recognized.
struct LoopResult {
  std::int64_t keyframe = 0, matched = 0;
  bool merged = false;  ///< Two submaps became one; else a loop within one was closed.
  int inliers = 0;      ///< Pairs of landmarks that fit the similarity.
  int landmarks = 0;    ///< Of the place, found again in the keyframe.
  int fused = 0;        ///< Landmarks that turned out to be the same.
  double moved = 0.0;   ///< By how much the keyframe's center moved, the map's unit; 0: merged.
  double scale = 1.0;   ///< By which what was brought over, or the keyframe's surroundings, grew.
  SlamEvent event() const;
};

/// Makes the map agree with itself (Mur-Artal et al. 2015, section VII): within a submap the surroundings of the
/// keyframe are moved, landmarks fused and the error spread over the essential graph; of two submaps the younger is
/// brought over to the older. Bundle adjustment of the whole submap comes after it (GlobalBundleAdjustment).
LoopResult correct_loop(MapGraph& graph, const OrbSlamOptions& options, const VerifiedLoop& loop);

}  // namespace rastro
