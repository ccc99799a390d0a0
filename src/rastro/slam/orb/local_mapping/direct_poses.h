// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/slam/orb/direct_alignment.h"
#include "rastro/slam/orb/map/map_graph.h"

namespace rastro {

/// Aligns keyframes with those that share most landmarks and with the oldest that share enough, which keeps drift
/// small. Bundle adjustment weighs these poses against the features.
class DirectPoses {
 public:
  /// Both outlive this; `alignment`: null where there is none, and this does nothing.
  DirectPoses(const DirectAlignment* alignment, MapGraph& graph) : alignment_(alignment), graph_(graph) {}

  /// The view of a new keyframe (may be null); returns what frames are aligned with, or null.
  std::shared_ptr<const DirectView> add(std::int64_t keyframe, const DirectView* view);
  /// Adds the direct poses of a keyframe of the graph.
  void connect(std::int64_t keyframe);
  std::size_t bytes() const { return keyframes_.bytes(); }

 private:
  std::vector<std::int64_t> neighbors(std::int64_t keyframe) const;
  void align(std::int64_t keyframe, std::int64_t camera);

  const DirectAlignment* alignment_;
  MapGraph& graph_;
  DirectKeyframes keyframes_{60};
};

}  // namespace rastro
