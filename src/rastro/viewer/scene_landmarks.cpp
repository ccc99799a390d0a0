// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/map/landmarks/landmark_uncertainty.h"
#include "rastro/viewer/scene_parts.h"
#include "rastro/viewer/thin_points.h"

namespace rastro::detail {
namespace {

using Covariance = std::optional<Eigen::Matrix3d>;

/// Indices of the landmarks of the scene.
std::vector<std::size_t> shown_landmarks(const SceneJob& job, const LandmarkLayer& layer) {
  std::vector<std::size_t> indices;
  std::vector<float> positions;
  for (std::size_t k = 0; k < layer.landmarks.size(); ++k) {
    const Landmark& landmark = layer.landmarks[k];
    if (job.options.submap >= 0 && submap_of(job.map, landmark) != job.options.submap) continue;
    indices.push_back(k);
    append(positions, landmark.position);
  }
  std::vector<std::size_t> shown;
  for (const std::uint32_t kept : thin_points(positions, 0.0, job.options.max_points)) shown.push_back(indices[kept]);
  return shown;
}

std::vector<Covariance> covariances_of(const SceneJob& job, const LandmarkLayer& layer,
                                       const std::vector<std::size_t>& shown) {
  std::vector<Covariance> covariances(shown.size());
  constexpr int grain = 256;
  job.pool.for_chunks(0, static_cast<int>(shown.size()), grain, [&](int begin, int end) {
    for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k)
      covariances[k] = layer.estimates.empty() ? landmark_covariance(job.map, layer.landmarks[shown[k]])
                                               : Covariance(layer.estimates[shown[k]].covariance);
  });
  return covariances;
}

/// Of an observed landmark along its mean viewing direction, where it is least certain; of a filter's over all axes.
float sigma_of(const Landmark& landmark, const Covariance& covariance) {
  double variance = 0.0;
  if (covariance && landmark.observations.empty()) variance = covariance->trace();
  if (covariance && !landmark.observations.empty()) variance = landmark.direction.dot(*covariance * landmark.direction);
  return variance > 0.0 ? static_cast<float>(std::sqrt(variance)) : std::numeric_limits<float>::quiet_NaN();
}

/// Of the keyframe that observed it first; 0 where that is not known.
std::uint32_t row_of(const SceneJob& job, const Landmark& landmark) {
  if (landmark.observations.empty()) return 0;
  return job.rows.row_of(job.map, landmark.observations.front().keyframe).value_or(0);
}

void add_ellipsoids(const SceneJob& job, const LandmarkLayer& layer, const std::vector<std::size_t>& shown,
                    const std::vector<Covariance>& covariances, ViewScene& scene) {
  std::vector<std::size_t> known;
  for (std::size_t k = 0; k < shown.size(); ++k)
    if (covariances[k] && covariances[k]->allFinite()) known.push_back(k);
  SceneEllipsoids ellipsoids;
  ellipsoids.name = "landmark_covariances";
  for (const std::size_t chosen : evenly(known.size(), job.options.max_ellipsoids)) {
    const std::size_t k = known[chosen];
    append(ellipsoids.centers, layer.landmarks[shown[k]].position);
    append_axes(ellipsoids.axes, *covariances[k]);
  }
  if (!ellipsoids.centers.empty()) scene.layers.emplace_back(std::move(ellipsoids));
}

}  // namespace

void add_landmarks(const SceneJob& job, ViewScene& scene) {
  const auto layer = job.map.layer<LandmarkLayer>();
  if (!layer) return;
  const std::vector<std::size_t> shown = shown_landmarks(job, *layer);
  if (shown.empty()) return;
  const std::vector<Covariance> covariances = covariances_of(job, *layer, shown);
  ScenePoints points;
  points.name = LandmarkLayer::layer_name;
  for (std::size_t k = 0; k < shown.size(); ++k) {
    const Landmark& landmark = layer->landmarks[shown[k]];
    append(points.positions, landmark.position);
    points.sigmas.push_back(sigma_of(landmark, covariances[k]));
    if (layer->estimates.empty()) points.keyframes.push_back(row_of(job, landmark));
  }
  scene.layers.emplace_back(std::move(points));
  add_ellipsoids(job, *layer, shown, covariances, scene);
}

}  // namespace rastro::detail
