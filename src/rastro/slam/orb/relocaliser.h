// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "rastro/slam/orb/options.h"
#include "rastro/slam/orb/place_memory.h"

namespace rastro {

/// Where in the map a frame is.
struct Relocation {
  std::int64_t keyframe = 0;  ///< That it is most like.
  SE3 camera_from_world;      ///< World: of the keyframe's submap.
  int inliers = 0;            ///< Landmarks that fit the pose.
};

/// Finds a frame anywhere in the map without a guess, METHODS 6 (Mur-Artal et al. 2015, section V.C). Only while
/// nothing else works on the graph.
class Relocaliser {
 public:
  /// Both outlive this.
  Relocaliser(const OrbSlamOptions& options, const MapGraph& graph, PlaceMemory& places);

  /// nullopt: found nowhere with at least min_inliers landmarks.
  std::optional<Relocation> find(const FeatureFrame& frame);

 private:
  std::optional<Relocation> try_keyframe(const FeatureFrame& frame, const BagOfWords& words, std::int64_t keyframe);

  OrbSlamOptions options_;
  const MapGraph& graph_;
  PlaceMemory& places_;
};

}  // namespace rastro
