// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "rastro/backend/guided_search.h"
#include "rastro/math/sim3.h"
#include "rastro/slam/orb/map/map_graph.h"

namespace rastro {

struct LandmarkSearchOptions {
  double radius_px = 8.0;  ///< Half the side of the search window at the finest level; it grows with the level's scale.
  MatchLimits limits;
  double min_view_cosine = 0.5;     ///< See GuidedSearchOptions.
  bool check_right_camera = false;  ///< Only where `camera_from_world` keeps the landmarks' unit.
};

/// Matches landmarks of the map to features of a frame. `camera_from_world` may change the unit. `subject` of a match
/// is the index of its landmark in `landmarks`. Ascending by feature.
std::vector<FeatureMatch> search_landmarks(const MapGraph& graph, const std::vector<std::int64_t>& landmarks,
                                           const FeatureFrame& frame, const Sim3& camera_from_world,
                                           const LandmarkSearchOptions& options);

/// Eight rotations of a camera that move every pixel by more than a search window of `window_px`: under them no
/// landmark can be matched to itself, so what is found is found by chance.
std::array<SO3, 8> rotations_beyond_windows(double window_px, const Camera& camera);

/// Landmarks of a keyframe and of those that share at least `least_shared` landmarks with it, at most `most_keyframes`;
/// ascending.
std::vector<std::int64_t> landmarks_around(const MapGraph& graph, std::int64_t keyframe, int least_shared,
                                           std::size_t most_keyframes);

/// One per feature of the keyframe: 1 if it observes a landmark.
std::vector<std::uint8_t> features_with_landmarks(const MapKeyframe& keyframe);
/// Landmarks that the keyframe observes, in the order of its features.
std::vector<std::int64_t> landmarks_of(const MapKeyframe& keyframe);

}  // namespace rastro
