// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rastro/slam/orb/map/keyframe_database.h"
#include "rastro/slam/orb/options.h"

namespace rastro {

/// The pose of a relocalized frame.
struct Relocation {
  std::int64_t keyframe = 0;  ///< The most similar keyframe.
  SE3 camera_from_world;      ///< World: of the keyframe's submap.
  int inliers = 0;            ///< Landmarks that fit the pose.
};

/// Relocalizes a frame in the whole map without a pose prior, METHODS 6 (Mur-Artal et al. 2015, section V.C). Only
/// while nothing else uses the graph.
class FrameRelocalizer {
 public:
  /// Both outlive this.
  FrameRelocalizer(const OrbSlamOptions& options, const MapGraph& graph, KeyframeDatabase& database);

  /// nullopt: no pose with at least `min_inliers` landmarks. `first`: keyframes to try before all others.
  std::optional<Relocation> find(const FeatureFrame& frame, int min_inliers,
                                 const std::vector<std::int64_t>& first = {});

 private:
  std::optional<Relocation> try_keyframe(const FeatureFrame& frame, const BagOfWords& words,
                                         std::int64_t keyframe) const;
  std::optional<SE3> pose_by_words(const FeatureFrame& frame, const BagOfWords& words,
                                   const MapKeyframe& keyframe) const;

  OrbSlamOptions options_;
  const MapGraph& graph_;
  KeyframeDatabase& database_;
};

}  // namespace rastro
