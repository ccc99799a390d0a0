// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/landmark_search.h"

#include <algorithm>
#include <cmath>

namespace rastro {

std::vector<FeatureMatch> search_landmarks(const MapGraph& graph, const std::vector<std::int64_t>& landmarks,
                                           const FeatureFrame& frame, const Sim3& camera_from_world, double radius_px,
                                           const MatchLimits& limits, const std::vector<std::uint8_t>& taken) {
  constexpr double least_depth = 1e-6, least_cosine = 0.5;
  const Camera& camera = graph.camera();
  const std::vector<double>& scales = graph.level_scales();
  const int last = static_cast<int>(scales.size()) - 1;
  const double log_scale = std::log(graph.orb_options().scale_factor);
  const Eigen::Vector3d centre = camera_from_world.inverse().translation();
  std::vector<ExpectedFeature> expected;
  for (std::uint32_t i = 0; i < landmarks.size(); ++i) {
    const MapLandmark& landmark = graph.landmark(landmarks[i]);
    const Eigen::Vector3d p = camera_from_world * landmark.position;
    if (!(p.z() > least_depth)) continue;
    const auto x = static_cast<float>(camera.fx * p.x() / p.z() + camera.cx);
    const auto y = static_cast<float>(camera.fy * p.y() / p.z() + camera.cy);
    if (!frame.holds(x, y)) continue;
    // Seen from too near or far, or from behind, it looks different. In the landmarks' unit.
    const Eigen::Vector3d way = landmark.position - centre;
    const double distance = way.norm(), far = static_cast<double>(landmark.max_distance);
    if (distance < 0.8 * static_cast<double>(landmark.min_distance) || distance > 1.25 * far) continue;
    if (way.dot(landmark.direction) < least_cosine * distance) continue;
    const int level = std::clamp(static_cast<int>(std::ceil(std::log(far / distance) / log_scale - 0.5)), 0, last);
    expected.push_back({i, x, y, static_cast<float>(radius_px * scales[static_cast<std::size_t>(level)]), std::nanf(""),
                        static_cast<std::uint8_t>(std::max(0, level - 1)),
                        static_cast<std::uint8_t>(std::min(last, level + 1)), &landmark.descriptor});
  }
  return match_expected(frame, expected, limits, taken);
}

std::vector<std::int64_t> landmarks_around(const MapGraph& graph, std::int64_t keyframe, int least_shared,
                                           std::size_t most_keyframes) {
  std::vector<std::int64_t> landmarks;
  const auto add = [&](std::int64_t id) {
    for (const std::int64_t landmark : graph.keyframe(id).landmarks) {
      if (landmark >= 0) landmarks.push_back(landmark);
    }
  };
  add(keyframe);
  for (const Neighbour& n : graph.covisible(keyframe, least_shared, most_keyframes)) add(n.id);
  std::sort(landmarks.begin(), landmarks.end());
  landmarks.erase(std::unique(landmarks.begin(), landmarks.end()), landmarks.end());
  return landmarks;
}

}  // namespace rastro
