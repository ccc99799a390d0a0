// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "rastro/backend/acceptance.h"
#include "rastro/math/sim3.h"
#include "rastro/slam/orb/map/map_graph.h"
#include "rastro/slam/orb/options.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// A loop closure with its verified relative pose.
struct VerifiedLoop {
  std::int64_t keyframe = 0, matched = 0;
  Sim3 keyframe_from_matched;  ///< Camera frames, each in its current unit.
  int inliers = 0;             ///< Pairs of landmarks that fit it.
  /// Features of the keyframe matched to landmarks around the other one.
  std::vector<std::pair<std::uint32_t, std::int64_t>> landmarks;
  int fitting = 0;                ///< Of these, where the similarity predicts them, within their accuracy.
  double chance_landmarks = 0.0;  ///< How many landmarks a wrong similarity would find.
  /// Distance to the relative pose in the map, in standard deviations of its drift; 0 between submaps.
  double graph_sigmas = 0.0;

  Evidence evidence() const {
    return {.inliers = inliers,
            .compared = static_cast<int>(landmarks.size()),
            .predicted = static_cast<int>(landmarks.size()),
            .observed = fitting,
            .chance_observed = 1.0 + chance_landmarks,
            .graph_sigmas = graph_sigmas};
  }
};

/// The effect of a loop closure or merge on the map.
struct LoopResult {
  std::int64_t keyframe = 0, matched = 0;
  bool merged = false;  ///< Two submaps were merged; else a loop within one was closed.
  int inliers = 0;      ///< Pairs of landmarks that fit the similarity.
  int landmarks = 0;    ///< Of the matched keyframe's surroundings, found in the keyframe.
  int fused = 0;        ///< Landmarks fused with their duplicates.
  double moved = 0.0;   ///< Distance that the keyframe's center moved, in the map's unit; 0: merged.
  double scale = 1.0;   ///< Scale change of the merged submap, or of the keyframe's surroundings.
  /// Of merged submaps: the keyframe of the pair in the submap that stayed, and what happened to the other submap.
  std::int64_t stayed = 0;
  Sim3 new_from_old;
  std::vector<std::pair<std::int64_t, Eigen::Vector3d>> transformed;  ///< Its keyframes and their new centers.
  SlamEvent event() const;
};

/// Corrects the map (Mur-Artal et al. 2015, section VII). Within a submap it moves the surroundings of the keyframe,
/// fuses landmarks and spreads the error over the essential graph. Of two submaps it transforms the younger into the
/// frame of the older. Bundle adjustment of the whole submap comes afterwards (GlobalBundleAdjustment).
LoopResult correct_loop(MapGraph& graph, const OrbSlamOptions& options, const VerifiedLoop& loop);

}  // namespace rastro
