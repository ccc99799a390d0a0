// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "rastro/math/sim3.h"
#include "rastro/slam/orb/map_graph.h"
#include "rastro/slam/orb/matching.h"
#include "rastro/slam/orb/options.h"

namespace rastro {

/// Where in a frame landmarks should be and are. `camera_from_world` may bring another unit than the landmarks'.
/// `subject` of a match is the index of its landmark in `landmarks`; features with `taken` (empty or one a feature) not
/// zero are passed over. Ascending by feature.
std::vector<FeatureMatch> search_landmarks(const MapGraph& graph, const std::vector<std::int64_t>& landmarks,
                                           const FeatureFrame& frame, const Sim3& camera_from_world, double radius_px,
                                           const MatchLimits& limits, const std::vector<std::uint8_t>& taken = {});

/// Landmarks of a keyframe and those that share landmarks with it, at most `most_keyframes`; ascending.
std::vector<std::int64_t> landmarks_around(const MapGraph& graph, std::int64_t keyframe, int least_shared,
                                           std::size_t most_keyframes);

}  // namespace rastro
