// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "rastro/slam/orb/map/map_graph.h"

namespace rastro::testing {

/// For tests only: maps made by hand, in which only the observations matter.
constexpr std::uint32_t feature_count = 40;

inline Camera small_camera() {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 500.0;
  camera.cx = 320.0;
  camera.cy = 240.0;
  return camera;
}

/// Features in a diagonal row with identical descriptors, in frame `id`, 0.1 s after the previous one. `depth_m` > 0:
/// depth of all features, for cameras `baseline` apart.
inline std::shared_ptr<const FeatureFrame> blank_frame(std::int64_t id, double depth_m = 0.0, double baseline = 0.0) {
  auto data = std::make_shared<ImageFeatures>();
  data->id = data->frame = id;
  data->stamp = 100000000 * id;
  for (std::uint32_t i = 0; i < feature_count; ++i)
    data->features.keypoints.push_back({static_cast<float>(10 * i), static_cast<float>(5 * i + 20), 31, 0, 1});
  data->features.levels.assign(feature_count, 0);
  data->features.descriptors.resize(feature_count);
  if (depth_m > 0.0) data->depths.assign(feature_count, static_cast<float>(depth_m));
  return std::make_shared<FeatureFrame>(std::move(data), small_camera(), baseline);
}

/// Adds a landmark that is feature `feature` in each of these keyframes.
inline std::int64_t add_landmark(MapGraph& graph, std::uint32_t feature, const std::vector<std::int64_t>& observers) {
  const std::int64_t id = graph.add_landmark({0.1 * feature, 0.2, 5.0}, observers.front()).id;
  for (const std::int64_t keyframe : observers) graph.add_observation(keyframe, feature, id);
  return id;
}

}  // namespace rastro::testing
