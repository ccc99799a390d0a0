// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/cloud/build_cloud.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/map/cloud/voxel_table.h"
#include "rastro/map/images/map_views.h"

namespace rastro {
namespace {

using detail::Voxel;
using detail::VoxelTable;
using detail::WorldSample;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int most_layers = 6;           ///< Maximum number of voxels on each side of a noisy surface.
constexpr double layer_sigmas = 3.0;     ///< Maximum distance of noisy measurements from the surface.
constexpr float same_side = 0.5F;        ///< Cosine between normals of one surface.
constexpr float least_agreement = 0.4F;  ///< Minimum length of the mean unit normal: less is a contradiction.

struct KeyedSample {
  std::uint64_t key = 0;
  WorldSample sample;
};
/// The samples of a keyframe, by shard.
using Sorted = std::array<std::vector<KeyedSample>, VoxelTable::shard_count>;

void sort_samples(const std::vector<SurfaceSample>& samples, const SE3& world_from_camera, const VoxelTable& table,
                  Sorted& sorted) {
  for (auto& shard : sorted) shard.clear();
  const Eigen::Matrix3f rotation = world_from_camera.rotation().matrix().cast<float>();
  for (const SurfaceSample& sample : samples) {
    KeyedSample keyed;
    keyed.sample.point = world_from_camera * sample.point_in_camera.cast<double>();
    keyed.key = table.key_of(keyed.sample.point);
    if (keyed.key == 0) continue;
    keyed.sample.normal = rotation * sample.normal_in_camera;
    keyed.sample.ray = rotation * (sample.point_in_camera / sample.point_in_camera.z());
    keyed.sample.sigma = sample.sigma;
    keyed.sample.color = sample.color;
    sorted[static_cast<std::size_t>(VoxelTable::shard_of(keyed.key))].push_back(keyed);
  }
}

VoxelTable gather(const Map& map, const CloudOptions& options, TaskPool* pool, const MapProgress& progress) {
  VoxelTable table(options.voxel_m);
  SurfaceOptions surface = detail::surface_options(map, options.stride, options.min_depth_m, options.max_depth_m);
  surface.grazing_deg = options.grazing_deg;
  std::vector<Sorted> group(options.keyframes_at_once);
  detail::MapViews views(map, detail::keyframes_of(map, options.submap), pool, options.keyframes_at_once);
  views.walk(
      [&](std::size_t slot, std::size_t keyframe, const UnpackedImages& images, const RayTable& rays) {
        sort_samples(surface_samples(images, rays, surface), map.keyframes[keyframe].world_from_camera, table,
                     group[slot]);
      },
      [&](std::size_t first, std::size_t count) {
        detail::for_each_index(pool, VoxelTable::shard_count, [&](std::size_t shard) {
          for (std::size_t slot = 0; slot < count; ++slot)
            for (const KeyedSample& keyed : group[slot][shard])
              table.add(keyed.key, keyed.sample, static_cast<std::int32_t>(first + slot));
        });
        while (table.size() > options.max_voxels) table.coarsen();
      },
      progress);
  return table;
}

struct KeyedPoint {
  std::uint64_t key = 0;
  CloudPoint point;
};

/// Sums over the voxels along a normal, relative to the center voxel's mean.
struct Layers {
  double weight = 0.0, variance = 0.0, along = 0.0, along2 = 0.0;
  Vector3f normal = Vector3f::Zero(), color = Vector3f::Zero();
  std::uint32_t count = 0, views = 0;

  void add(const Voxel& voxel, double mean_along) {
    // Within a voxel: the scatter along the measurements' own normals; between voxels: that of the means.
    const double own = voxel.along / voxel.weight;
    const double scatter = std::max(0.0, voxel.along2 / voxel.weight - own * own);
    weight += voxel.weight;
    variance += voxel.variance;
    along += voxel.weight * mean_along;
    along2 += voxel.weight * (mean_along * mean_along + scatter);
    normal += voxel.normal;
    color += voxel.color;
    count += voxel.count;
    views = std::max(views, voxel.views);
  }
  double mean() const { return along / weight; }

  double sigma() const {
    const double per_measurement = variance / weight;  // weighted mean of w times the variance
    const double expected = per_measurement / (weight / count);
    const double found = count > 1 ? std::max(0.0, along2 / weight - mean() * mean()) * count / (count - 1.0) : 0.0;
    return std::sqrt(std::max(expected, found) / std::max(1U, views));
  }
};

/// Makes one point from a voxel and those in front of and behind it over which noise spread the same surface; none if
/// another voxel represents it.
class Thinning {
 public:
  Thinning(const VoxelTable& table, const CloudOptions& options) : table_(table), options_(options) {}

  void add_points(int shard, std::vector<KeyedPoint>& points) const {
    for (const Voxel& voxel : table_.shard(shard)) add_point(voxel, points);
  }

 private:
  Vector3d mean_of(const Voxel& voxel) const {
    return table_.corner_of(voxel.key) + (voxel.position / voxel.weight).cast<double>();
  }

  void add_point(const Voxel& voxel, std::vector<KeyedPoint>& points) const {
    Layers layers;
    layers.add(voxel, 0.0);
    const Vector3d middle = mean_of(voxel);
    const float length = voxel.normal.norm();
    const Vector3d normal = length > 0.0F ? Vector3d((voxel.normal / length).cast<double>()) : Vector3d::Zero();
    if (length > 0.0F) {
      add_layers(voxel, middle, normal, 1.0, layers);
      add_layers(voxel, middle, normal, -1.0, layers);
      const double off = layers.mean();
      if (std::abs(off) > 0.5 * table_.side_m() && stands_there(middle + off * normal, voxel.key)) return;
    }
    if (static_cast<int>(layers.count) < options_.min_count || static_cast<int>(layers.views) < options_.min_views)
      return;
    if (length > 0.0F && layers.normal.norm() < least_agreement * layers.weight) return;
    points.push_back({voxel.key, point_of(layers, middle + layers.mean() * normal)});
  }

  void add_layers(const Voxel& voxel, const Vector3d& middle, const Vector3d& normal, double side,
                  Layers& layers) const {
    const double reach = layer_sigmas * std::sqrt(voxel.count / voxel.weight);
    const int steps = std::min(most_layers, static_cast<int>(std::ceil(reach / table_.side_m())));
    std::uint64_t last = voxel.key;
    for (int step = 1; step <= steps; ++step) {
      const std::uint64_t key = table_.key_of(middle + side * step * table_.side_m() * normal);
      if (key == last || key == 0) continue;
      last = key;
      const Voxel* other = table_.find(key);
      if (other == nullptr) continue;
      const float other_length = other->normal.norm();
      if (other_length > 0.0F && other->normal.dot(normal.cast<float>()) < same_side * other_length) continue;
      const double along = normal.dot(mean_of(*other) - middle);
      if (std::abs(along) <= reach) layers.add(*other, along);
    }
  }

  bool stands_there(const Vector3d& position, std::uint64_t self) const {
    const std::uint64_t key = table_.key_of(position);
    return key != 0 && key != self && table_.find(key) != nullptr;
  }

  static CloudPoint point_of(const Layers& layers, const Vector3d& position) {
    CloudPoint point;
    point.position = position.cast<float>();
    if (!layers.normal.isZero()) point.normal = layers.normal.normalized();
    for (std::size_t k = 0; k < 3; ++k) {
      const double mean = layers.color[static_cast<int>(k)] / layers.weight;
      point.color[k] = static_cast<std::uint8_t>(std::clamp(std::lround(mean), 0L, 255L));
    }
    point.count = layers.count;
    point.sigma = static_cast<float>(layers.sigma());
    return point;
  }

  const VoxelTable& table_;
  const CloudOptions& options_;
};

}  // namespace

double precise_depth_m(const Map& map) {
  constexpr double largest_share = 0.03, nearest_m = 1.0, farthest_m = 100.0;
  if (map.cameras.empty() || map.cameras.front().kind != CameraKind::stereo) return CloudOptions().max_depth_m;
  const double sigma_per_m2 = map.cameras.front().depth_noise.sigma_per_m2;
  return sigma_per_m2 > 0.0 ? std::clamp(largest_share / sigma_per_m2, nearest_m, farthest_m) : farthest_m;
}

CloudOptions cloud_options_for(const Map& map) {
  CloudOptions options;
  const double usual_m = options.max_depth_m;
  options.max_depth_m = precise_depth_m(map);
  options.voxel_m *= options.max_depth_m / usual_m;
  return options;
}

void keep_within(std::size_t bytes, const Map& map, CloudOptions& options) {
  if (map.cameras.empty()) return;
  constexpr std::size_t a_voxel = 256;  // with its point, and room to grow
  constexpr std::size_t fewest_voxels = 1 << 14;
  // A sample is sorted in a list that grows, and every other one is a voxel before voxels can be merged.
  constexpr std::size_t a_sample = 2 * sizeof(KeyedSample) + a_voxel / 2;
  constexpr std::size_t a_pixel = 16;  // as it is unpacked
  const Camera& camera = map.cameras.front().intrinsics;
  const std::size_t pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height),
                    stride = static_cast<std::size_t>(options.stride),
                    a_keyframe = 1 + pixels * a_pixel + pixels / (stride * stride) * a_sample;
  const std::size_t of_keyframes = std::max(bytes / 3, a_keyframe), of_voxels = bytes - std::min(bytes, of_keyframes);
  options.keyframes_at_once = std::min(options.keyframes_at_once, of_keyframes / a_keyframe);
  options.max_voxels = std::min(options.max_voxels, std::max(fewest_voxels, of_voxels / a_voxel));
}

PointCloud build_cloud(const Map& map, const CloudOptions& options, TaskPool* pool, const MapProgress& progress) {
  RASTRO_CHECK(options.voxel_m > 0.0 && options.keyframes_at_once > 0, "voxels have a size, and groups keyframes");
  std::optional<VoxelTable> table = gather(map, options, pool, progress);
  std::array<std::vector<KeyedPoint>, VoxelTable::shard_count> parts;
  const Thinning thinning(*table, options);
  detail::for_each_index(pool, parts.size(),
                         [&](std::size_t shard) { thinning.add_points(static_cast<int>(shard), parts[shard]); });
  PointCloud cloud;
  cloud.voxel_m = table->side_m();
  table.reset();  // it is much larger than the points
  std::vector<KeyedPoint> points;
  for (auto& part : parts) {
    points.insert(points.end(), part.begin(), part.end());
    std::vector<KeyedPoint>().swap(part);
  }
  std::sort(points.begin(), points.end(), [](const KeyedPoint& a, const KeyedPoint& b) { return a.key < b.key; });
  cloud.points.reserve(points.size());
  for (const KeyedPoint& point : points) cloud.points.push_back(point.point);
  return cloud;
}

}  // namespace rastro
