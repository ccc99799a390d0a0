// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/slam/orb/map/map_graph.h"

namespace rastro {

/// The local map for tracking: the surroundings of one keyframe, contiguous in memory. Immutable.
struct MapView {
  struct Keyframe {
    std::int64_t id = 0;
    SE3 camera_from_world;
    double unit = 1.0;
    int submap = 0;
    /// Its landmarks with at least three observers (two while the map has no more keyframes); one fewer with depth.
    int landmarks = 0;
    std::shared_ptr<const FeatureFrame> frame;
  };
  std::int64_t center = -1;         ///< The keyframe in the center.
  std::int64_t latest = -1;         ///< Newest keyframe of the map when the view was made.
  std::vector<Keyframe> keyframes;  ///< Ids ascend.

  // Landmarks; ids ascend.
  std::vector<std::int64_t> ids;
  std::vector<Eigen::Vector3d> positions, directions;
  std::vector<float> min_distances, max_distances;
  std::vector<Descriptor> descriptors;
  std::vector<Eigen::Matrix3d> covariances;  ///< Of the positions, given the keyframes' poses; empty: not asked for.
  std::vector<std::uint32_t> seen_begin;     ///< One per landmark and one more, into seen_by.
  std::vector<std::uint32_t> seen_by;        ///< Indices into keyframes.

  std::size_t size() const { return ids.size(); }
  /// Index of a landmark or keyframe; -1: not in the view.
  std::int64_t find(std::int64_t landmark) const;
  std::int64_t find_keyframe(std::int64_t id) const;
  /// Must be in the view.
  const Keyframe& keyframe(std::int64_t id) const { return keyframes[static_cast<std::size_t>(find_keyframe(id))]; }
};

struct MapViewOptions {
  int keyframes = 40;
  int landmarks = 6000;
  bool covariances = false;
};

/// The view of a keyframe: those that share landmarks with it, and those that share with these, most first.
std::shared_ptr<const MapView> view_of(const MapGraph& graph, std::int64_t center, const MapViewOptions& options);

}  // namespace rastro
