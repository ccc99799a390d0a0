// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/features/feature_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "rastro/map/features/feature_layer.h"
#include "rastro/map/images/map_views.h"

namespace rastro {
namespace {

using Eigen::Vector3d;

constexpr double cell_m = 0.05;
constexpr double max_distance_m = cell_m;  ///< At most the cell size, for the search in adjacent cells.
constexpr double pose_sigma_m = 0.005;     ///< Between keyframes, in addition to depth noise.
constexpr double max_distance_sigmas = 3.0;
constexpr int max_bit_distance = 60;        ///< Of 256.
constexpr float max_float_distance = 0.6F;  ///< Share of the descriptor's length.

float distance(const Features& a, std::size_t i, const Features& b, std::size_t j) {
  if (a.length != b.length) return std::numeric_limits<float>::infinity();
  if (a.binary()) {
    const int bits = hamming_distance(a.descriptors[i], b.descriptors[j]);
    return static_cast<float>(bits) / max_bit_distance;
  }
  const auto at = [&](const Features& of, std::size_t k) {
    return Eigen::Map<const Eigen::VectorXf>(of.floats.data() + k * static_cast<std::size_t>(of.length), of.length);
  };
  return (at(a, i) - at(b, j)).norm() / (max_float_distance * std::max(1e-9F, at(a, i).norm()));
}

struct Growing {
  Vector3d sum = Vector3d::Zero();
  double weight = 0.0, sigma = 0.0;
  FeaturePoint point;
  Vector3d mean() const { return sum / weight; }
};

class FeatureMerging {
 public:
  FeatureMerging(const Map& map, int submap) : map_(map), layer_(map.layer<FeatureLayer>()) {
    if (!layer_ || map.cameras.empty()) return;
    for (const std::size_t keyframe : detail::keyframes_of(map, submap)) add(keyframe);
  }

  std::vector<FeaturePoint> take() {
    std::vector<FeaturePoint> points;
    for (Growing& growing : all_) {
      if (growing.point.views.size() < 2) continue;
      growing.point.position = growing.mean();
      growing.point.error_px = error_of(growing.point);
      points.push_back(std::move(growing.point));
    }
    return points;
  }

 private:
  using Cell = std::tuple<int, int, int>;
  static Cell cell_of(const Vector3d& position) {
    const Eigen::Vector3i cell = (position / cell_m).array().floor().cast<int>();
    return {cell.x(), cell.y(), cell.z()};
  }

  const MapCamera& camera_at(std::size_t keyframe) const {
    return map_.cameras[static_cast<std::size_t>(map_.keyframes[keyframe].camera)];
  }
  const Features& features_of(std::size_t keyframe) const {
    return layer_->find(map_.keyframes[keyframe].id)->features;
  }

  void add(std::size_t keyframe) {
    const ImageFeatures* image = layer_->find(map_.keyframes[keyframe].id);
    if (!image) return;
    const MapCamera& camera = camera_at(keyframe);
    const SE3& world_from_camera = map_.keyframes[keyframe].world_from_camera;
    for (std::size_t k = 0; k < image->features.size() && k < image->depths.size(); ++k) {
      const double z = static_cast<double>(image->depths[k]);
      const Keypoint& at = image->features.keypoints[k];
      const auto ray = z > 0.0 ? camera.intrinsics.unproject({at.x, at.y}) : std::nullopt;
      if (!ray) continue;
      const Vector3d position = world_from_camera * (z * Vector3d(ray->x(), ray->y(), 1.0));
      if (!(position.cwiseAbs().maxCoeff() < 1e6)) continue;
      add_feature({keyframe, k}, position, camera.depth_noise.sigma_m + camera.depth_noise.sigma_per_m2 * z * z);
    }
  }

  void add_feature(const FeatureView& view, const Vector3d& position, double sigma) {
    Growing* best = nearest(view, position, sigma);
    if (best == nullptr) {
      cells_[cell_of(position)].push_back(all_.size());
      best = &all_.emplace_back();
    }
    const double weight = 1.0 / (sigma * sigma);
    best->sum += weight * position;
    best->weight += weight;
    best->sigma = sigma;
    best->point.views.push_back(view);
  }

  Growing* nearest(const FeatureView& view, const Vector3d& position, double sigma) {
    Growing* best = nullptr;
    float least = 1.0F;
    const auto [x, y, z] = cell_of(position);
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz) {
          const auto found = cells_.find({x + dx, y + dy, z + dz});
          if (found == cells_.end()) continue;
          for (const std::size_t index : found->second) {
            Growing& other = all_[index];
            if (!is_near(other, view, position, sigma)) continue;
            const FeatureView& last = other.point.views.back();
            const float difference =
                distance(features_of(view.keyframe), view.feature, features_of(last.keyframe), last.feature);
            if (difference < least) least = difference, best = &other;
          }
        }
    return best;
  }

  static bool is_near(const Growing& other, const FeatureView& view, const Vector3d& position, double sigma) {
    if (other.point.views.back().keyframe == view.keyframe) return false;
    const double limit = max_distance_sigmas * std::hypot(sigma, other.sigma, pose_sigma_m);
    return (other.mean() - position).norm() <= std::min(limit, max_distance_m);
  }

  double error_of(const FeaturePoint& point) const {
    double sum = 0.0;
    int count = 0;
    for (const FeatureView& view : point.views) {
      const Keypoint& at = features_of(view.keyframe).keypoints[view.feature];
      const SE3 camera_from_world = map_.keyframes[view.keyframe].world_from_camera.inverse();
      const auto pixel = camera_at(view.keyframe).intrinsics.project(camera_from_world * point.position);
      if (!pixel) continue;
      sum += (*pixel - Eigen::Vector2d(at.x, at.y)).norm();
      ++count;
    }
    return count > 0 ? sum / count : 0.0;
  }

  const Map& map_;
  std::shared_ptr<const FeatureLayer> layer_;
  std::vector<Growing> all_;
  std::map<Cell, std::vector<std::size_t>> cells_;
};

}  // namespace

std::vector<FeaturePoint> feature_points(const Map& map, int submap) { return FeatureMerging(map, submap).take(); }

}  // namespace rastro
