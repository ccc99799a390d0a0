// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/slam/lsd/options.h"
#include "rastro/slam/lsd/semi_dense_graph.h"

namespace rastro {

/// The depths of a keyframe that the map keeps, in the world's unit.
std::shared_ptr<const SemiDenseDepth> depths_in_map(const SemiDenseKeyframe& keyframe, double world_per_unit,
                                                    const LsdOptions& options);
/// At most: max_depth_sigma may leave out more.
std::size_t bytes_in_map(const SemiDenseKeyframe& keyframe, const LsdOptions& options);

/// The depths in the last map, as long as somebody keeps that one: the next has most of them too. A change of a
/// keyframe's scale of less than a thousandth counts as none, which for a map of a killed run is good enough.
class KnownMapDepths {
 public:
  std::shared_ptr<const SemiDenseDepth> of(const std::shared_ptr<const SemiDenseKeyframe>& keyframe,
                                           double world_per_unit, const LsdOptions& options);

 private:
  struct Known {
    std::weak_ptr<const SemiDenseKeyframe> keyframe;
    std::weak_ptr<const SemiDenseDepth> depths;
    double world_per_unit = 1.0;
  };
  std::vector<Known> known_;  ///< By the keyframe's id.
};

}  // namespace rastro
