// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "rastro/map/images/image_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/map/layer_type.h"
#include "rastro/map/scans/scan_layer.h"
#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/viewer/scene_parts.h"
#include "rastro/viewer/thin_points.h"

namespace rastro::detail {
namespace {

constexpr float unknown_sigma = std::numeric_limits<float>::quiet_NaN();

/// Points with the rows of their keyframes; the rows are empty where they are not known.
struct RowedCloud {
  PointCloud cloud;
  std::vector<std::uint32_t> rows;
};

/// Colors and sigmas only where a point has one.
ScenePoints points_of(const RowedCloud& all, std::string name, double side, std::size_t most) {
  const std::vector<CloudPoint>& points = all.cloud.points;
  std::vector<float> positions;
  positions.reserve(3 * points.size());
  for (const CloudPoint& point : points) append(positions, point.position.cast<double>());
  const bool colored = std::any_of(points.begin(), points.end(),
                                   [](const CloudPoint& each) { return each.color != std::array<std::uint8_t, 3>{}; });
  const bool has_sigmas =
      std::any_of(points.begin(), points.end(), [](const CloudPoint& each) { return each.sigma > 0.0F; });
  ScenePoints scene;
  scene.name = std::move(name);
  for (const std::uint32_t index : thin_points(positions, side, most)) {
    const CloudPoint& point = points[index];
    append(scene.positions, point.position.cast<double>());
    if (colored) scene.colors.insert(scene.colors.end(), point.color.begin(), point.color.end());
    if (has_sigmas) scene.sigmas.push_back(point.sigma > 0.0F ? point.sigma : unknown_sigma);
    if (!all.rows.empty()) scene.keyframes.push_back(all.rows[index]);
  }
  return scene;
}

/// Of a layer with an item per keyframe: its points keyframe by keyframe, so that each has a row. About `most`.
template <typename L>
RowedCloud rowed_points(const SceneJob& job, const L& layer, std::size_t most) {
  RowedCloud all;
  const std::size_t most_each = 1 + most / std::max<std::size_t>(1, layer.of.size());
  for (const auto& [id, item] : layer.of) {
    const auto row = job.rows.row_of(job.map, id);
    if (!row) continue;
    L alone;
    alone.of[id] = item;
    layer_type(L::layer_name)->add_points(job.map, alone, job.options.submap, most_each, all.cloud);
    all.rows.resize(all.cloud.points.size(), *row);
  }
  return all;
}

// Thinning chooses among several times as many points as stay.
constexpr std::size_t candidates = 4;

ScenePoints points_of_layer(const SceneJob& job, const std::string& name, const Layer& layer) {
  const std::size_t most = job.options.max_points;
  if (const auto* scans = dynamic_cast<const ScanLayer*>(&layer))
    return points_of(rowed_points(job, *scans, candidates * most), name, scans->cell_m, most);
  if (const auto* semi_dense = dynamic_cast<const SemiDenseLayer*>(&layer))
    return points_of(rowed_points(job, *semi_dense, candidates * most), name, 0.0, most);
  RowedCloud all;
  if (const LayerType* type = layer_type(name))
    type->add_points(job.map, layer, job.options.submap, candidates * most, all.cloud);
  return points_of(all, name, 0.0, most);
}

}  // namespace
}  // namespace rastro::detail

namespace rastro {

ScenePoints scene_points(PointCloud cloud, std::string name, std::size_t most) {
  return detail::points_of({std::move(cloud), {}}, std::move(name), 0.0, most);
}

}  // namespace rastro

namespace rastro::detail {

void add_layer_points(const SceneJob& job, ViewScene& scene) {
  for (const auto& [name, layer] : job.map.layers.all()) {
    if (name == LandmarkLayer::layer_name) continue;
    ScenePoints points = points_of_layer(job, name, *layer);
    if (!points.positions.empty()) scene.layers.emplace_back(std::move(points));
  }
}

PointCloud add_cloud(const SceneJob& job, ViewScene& scene) {
  if (!images_of(job.map)) return {};
  CloudOptions options = cloud_options_for(job.map);
  options.submap = job.options.submap;
  RowedCloud all{build_cloud(job.map, options, &job.pool, job.progress), {}};
  ScenePoints points = points_of(all, "cloud", 0.0, job.options.max_points);
  if (!points.positions.empty()) scene.layers.emplace_back(std::move(points));
  return std::move(all.cloud);
}

}  // namespace rastro::detail
