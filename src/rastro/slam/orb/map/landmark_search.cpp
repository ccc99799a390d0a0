// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/landmark_search.h"

#include <algorithm>
#include <utility>

namespace rastro {

std::vector<FeatureMatch> search_landmarks(const MapGraph& graph, const std::vector<std::int64_t>& landmarks,
                                           const FeatureFrame& frame, const Sim3& camera_from_world,
                                           const LandmarkSearchOptions& options) {
  std::vector<float> radii;
  for (const double scale : graph.level_scales()) radii.push_back(static_cast<float>(options.radius_px * scale));
  GuidedSearch search(graph.camera(), frame.grid(), std::move(radii),
                      {.baseline = options.check_right_camera ? graph.baseline() : 0.0,
                       .scale_factor = graph.orb_options().scale_factor,
                       .min_view_cosine = options.min_view_cosine});
  const Eigen::Vector3d center = camera_from_world.inverse().translation();
  for (std::uint32_t i = 0; i < landmarks.size(); ++i) {
    const MapLandmark& landmark = graph.landmark(landmarks[i]);
    // A landmark looks different from too near, too far, or behind: distances are in the landmarks' unit.
    search.add_landmark(
        i, {landmark.position, landmark.direction, landmark.min_distance, landmark.max_distance, landmark.descriptor},
        camera_from_world * landmark.position, center);
  }
  return search.match(options.limits);
}

std::array<SO3, 8> rotations_beyond_windows(double window_px, const Camera& camera) {
  const double angle_rad = 3.0 * window_px / camera.fx;
  constexpr std::array shares{-1.0, -0.7, 0.7, 1.0};
  std::array<SO3, 8> rotations;
  for (std::size_t k = 0; k < shares.size(); ++k) {
    rotations[2 * k] = SO3::exp({shares[k] * angle_rad, 0.0, 0.0});
    rotations[2 * k + 1] = SO3::exp({0.0, shares[k] * angle_rad, 0.0});
  }
  return rotations;
}

std::vector<std::int64_t> landmarks_around(const MapGraph& graph, std::int64_t keyframe, int least_shared,
                                           std::size_t most_keyframes) {
  std::vector<std::int64_t> landmarks = landmarks_of(graph.keyframe(keyframe));
  for (const Neighbor& n : graph.covisible(keyframe, least_shared, most_keyframes)) {
    const std::vector<std::int64_t> theirs = landmarks_of(graph.keyframe(n.id));
    landmarks.insert(landmarks.end(), theirs.begin(), theirs.end());
  }
  std::sort(landmarks.begin(), landmarks.end());
  landmarks.erase(std::unique(landmarks.begin(), landmarks.end()), landmarks.end());
  return landmarks;
}

std::vector<std::uint8_t> features_with_landmarks(const MapKeyframe& keyframe) {
  std::vector<std::uint8_t> use;
  for (const std::int64_t landmark : keyframe.landmarks) use.push_back(landmark >= 0 ? 1 : 0);
  return use;
}

std::vector<std::int64_t> landmarks_of(const MapKeyframe& keyframe) {
  std::vector<std::int64_t> landmarks;
  for (const std::int64_t landmark : keyframe.landmarks) {
    if (landmark >= 0) landmarks.push_back(landmark);
  }
  return landmarks;
}

}  // namespace rastro
