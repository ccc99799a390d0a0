// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/slam/orb/map/map_graph.h"

namespace rastro {

/// What tracking knows of the map: the surroundings of one keyframe, side by side in memory. Never changes once made.
struct MapView {
  struct Keyframe {
    std::int64_t id = 0;
    SE3 camera_from_world;
    double unit = 1.0;
    int submap = 0;
    int landmarks = 0;  ///< That it sees and at least three keyframes do (two while there are no more).
    std::shared_ptr<const FeatureFrame> frame;
  };
  std::int64_t center = -1;         ///< The keyframe.
  std::int64_t latest = -1;         ///< Newest keyframe that the map knew.
  std::vector<Keyframe> keyframes;  ///< Ids ascend.

  // Landmarks; ids ascend.
  std::vector<std::int64_t> ids;
  std::vector<Eigen::Vector3d> positions, directions;
  std::vector<float> min_distances, max_distances;
  std::vector<Descriptor> descriptors;
  std::vector<std::uint32_t> seen_begin;  ///< One a landmark and one more, into seen_by.
  std::vector<std::uint32_t> seen_by;     ///< Indices into keyframes.

  std::size_t size() const { return ids.size(); }
  /// Index of a landmark or keyframe; -1: not here.
  std::int64_t find(std::int64_t landmark) const;
  std::int64_t find_keyframe(std::int64_t id) const;
  /// Must be here.
  const Keyframe& keyframe(std::int64_t id) const { return keyframes[static_cast<std::size_t>(find_keyframe(id))]; }
};

struct MapViewOptions {
  int keyframes = 40;
  int landmarks = 6000;
};

/// Of the keyframe, those that share landmarks with it, and those that share with these, most first.
std::shared_ptr<const MapView> view_of(const MapGraph& graph, std::int64_t center, const MapViewOptions& options);

}  // namespace rastro
