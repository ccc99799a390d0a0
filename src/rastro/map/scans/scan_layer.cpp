// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/scans/scan_layer.h"

#include <fmt/format.h>

#include "rastro/map/file/bytes.h"
#include "rastro/map/graph/planar.h"
#include "rastro/map/grid/occupancy_mapper.h"

namespace rastro {
namespace {

constexpr double largest_cell_m = 100.0;

void put(ByteWriter& bytes, const Eigen::Vector2d& point) {
  bytes.put(point.x());
  bytes.put(point.y());
}

Eigen::Vector2d get_point(ByteReader& bytes) {
  const auto x = bytes.get<double>();
  return {x, bytes.get<double>()};
}

class ScanLayerType : public KeyframeLayerType<ScanLayer, KeyframeScans> {
 public:
  std::string header(const Layer& layer) const override {
    const ScanLayer& scans = typed(layer);
    ByteWriter bytes;
    for (const double value :
         {scans.cell_m, scans.model.occupied_probability, scans.model.free_probability, scans.model.largest_log_odds})
      bytes.put(value);
    return bytes.take();
  }
  std::shared_ptr<Layer> make(std::string_view header, const std::string& where) const override {
    ByteReader bytes(header, where);
    auto scans = std::make_shared<ScanLayer>();
    for (double* value : {&scans->cell_m, &scans->model.occupied_probability, &scans->model.free_probability,
                          &scans->model.largest_log_odds})
      *value = bytes.get<double>();
    bytes.finish();
    bytes.check(scans->cell_m > 1e-4 && scans->cell_m < largest_cell_m);
    bytes.check(scans->model.occupied_probability > 0.5 && scans->model.occupied_probability < 1.0);
    bytes.check(scans->model.free_probability > 0.0 && scans->model.free_probability < 0.5);
    bytes.check(scans->model.largest_log_odds > 0.0 && scans->model.largest_log_odds < 1e3);
    return scans;
  }

  std::string body_of(const KeyframeScans& scans) const override {
    ByteWriter bytes;
    bytes.put(static_cast<std::uint32_t>(scans.size()));
    for (const KeyframeScan& scan : scans) {
      put(bytes, scan.sensor);
      bytes.put(static_cast<std::uint32_t>(scan.points.size()));
      for (const Eigen::Vector2d& point : scan.points) put(bytes, point);
    }
    return bytes.take();
  }
  std::shared_ptr<const KeyframeScans> thing_of(KeyframeId, std::string_view body,
                                                const std::string& where) const override {
    constexpr std::size_t point_size = 2 * sizeof(double);
    ByteReader bytes(body, where);
    auto scans = std::make_shared<KeyframeScans>(bytes.count(point_size + sizeof(std::uint32_t)));
    for (KeyframeScan& scan : *scans) {
      scan.sensor = get_point(bytes);
      scan.points.resize(bytes.count(point_size));
      for (Eigen::Vector2d& point : scan.points) point = get_point(bytes);
    }
    bytes.finish();
    return scans;
  }

  LayerDescription describe(const Map&, const Layer& layer) const override {
    std::size_t scans = 0, returns = 0;
    for (const auto& [id, of_keyframe] : typed(layer).of) {
      scans += of_keyframe->size();
      for (const KeyframeScan& scan : *of_keyframe) returns += scan.points.size();
    }
    return {fmt::format("{} laser scans with {} returns; grid in cells of {:g} m", scans, returns, typed(layer).cell_m),
            {{"scans", static_cast<double>(scans)}, {"returns", static_cast<double>(returns)}}};
  }

  void add_points(const Map& map, const Layer& layer, int submap, std::size_t /*most*/,
                  PointCloud& cloud) const override {
    for (const auto& [id, scans] : typed(layer).of) {
      const Keyframe* keyframe = map.find(id);
      if (!keyframe || (submap >= 0 && keyframe->submap != submap)) continue;
      for (const KeyframeScan& scan : *scans) {
        for (const Eigen::Vector2d& in_body : scan.points) {
          CloudPoint point;
          point.position = (keyframe->world_from_camera * Eigen::Vector3d(in_body.x(), in_body.y(), 0.0)).cast<float>();
          point.count = 1;
          cloud.points.push_back(point);
        }
      }
    }
  }
};

}  // namespace

std::optional<OccupancyGrid> occupancy_grid_of(const Map& map, int submap) {
  const auto layer = map.layer<ScanLayer>();
  if (!layer) return std::nullopt;
  OccupancyMapper mapper(layer->cell_m, layer->model);
  for (const Keyframe& keyframe : map.keyframes) {
    const KeyframeScans* scans = keyframe.submap == submap ? layer->find(keyframe.id) : nullptr;
    if (!scans) continue;
    const SE2 world_from_body = in_plane(keyframe.world_from_camera);
    for (const KeyframeScan& scan : *scans) {
      std::vector<Eigen::Vector2d> points;
      points.reserve(scan.points.size());
      for (const Eigen::Vector2d& point : scan.points) points.push_back(world_from_body * point);
      mapper.insert(world_from_body * scan.sensor, points);
    }
  }
  return mapper.grid();
}

std::unique_ptr<LayerType> scans_layer_type() { return std::make_unique<ScanLayerType>(); }

}  // namespace rastro
