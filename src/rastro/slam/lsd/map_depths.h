// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/slam/lsd/options.h"
#include "rastro/slam/lsd/semi_dense_graph.h"

namespace rastro {

/// A keyframe's unit in that of the world.
struct KeyframeScale {
  double world_per_unit = 1.0;
  double variance = 0.0;  ///< Of its logarithm, relative to the mean of the map.
};

/// The depths of a keyframe that the map keeps, in the world's unit. What its scale may be off makes all of them less
/// certain, and has no part in which are kept.
std::shared_ptr<const SemiDenseDepth> depths_in_map(const SemiDenseKeyframe& keyframe, const KeyframeScale& scale,
                                                    const LsdOptions& options);
/// At most: max_depth_sigma may leave out more.
std::size_t bytes_in_map(const SemiDenseKeyframe& keyframe, const LsdOptions& options);

/// The depths in the last map, as long as somebody keeps that one: the next has most of them too. A change of a
/// keyframe's scale, or of its standard deviation, of less than a thousandth counts as none, which for a map of a
/// killed run is good enough.
class KnownMapDepths {
 public:
  std::shared_ptr<const SemiDenseDepth> of(const std::shared_ptr<const SemiDenseKeyframe>& keyframe,
                                           const KeyframeScale& scale, const LsdOptions& options);

 private:
  struct Known {
    std::weak_ptr<const SemiDenseKeyframe> keyframe;
    std::weak_ptr<const SemiDenseDepth> depths;
    KeyframeScale scale;
  };
  std::vector<Known> known_;  ///< By the keyframe's id.
};

}  // namespace rastro
