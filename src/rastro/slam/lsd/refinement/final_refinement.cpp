// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/refinement/final_refinement.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "rastro/math/median.h"

namespace rastro {
namespace {

constexpr int border_px = 4;
constexpr double most_uncertain = 0.3;  // Sigma of an inverse depth, of itself.
constexpr std::size_t least_points = 30;
constexpr double measured_factor = 2.0;  // Of sigmas: errors of a sensor's depths are alike among neighbors.

bool is_certain(const InverseDepthMap& depth, int x, int y) {
  const double mean = static_cast<double>(depth.mean.at(x, y)), variance = static_cast<double>(depth.variance.at(x, y));
  return variance > 0.0 && mean > 0.0 && variance < most_uncertain * most_uncertain * mean * mean;
}

}  // namespace

FinalRefinement::FinalRefinement(const LsdOptions& options, const SemiDenseGraph& graph, const LsdSensor& sensor)
    : options_(options),
      graph_(graph),
      camera_(sensor.camera),
      is_metric_(sensor.is_metric()),
      keyframes_(static_cast<std::size_t>(graph.size())) {
  std::set<int> anchored;
  for (std::int64_t id = 0; id < graph.size(); ++id) {
    PhotometricKeyframe& keyframe = keyframes_[static_cast<std::size_t>(id)];
    const Sim3& pose = graph.pose(id);
    keyframe.image = graph.keyframe(id).image.view();
    keyframe.mask = graph.keyframe(id).mask.view();
    keyframe.camera_from_world = SE3(pose.rotation(), pose.translation()).inverse();
    // The first one that has an image left: what is compared with nothing holds nothing else in place.
    keyframe.fixed = keyframe.image.empty() || anchored.insert(graph.submap(id)).second;
    choose_points(id);
  }
  choose_targets();
}

/// In each cell of the image the certain pixel with the largest gradient.
void FinalRefinement::choose_points(std::int64_t id) {
  const SemiDenseKeyframe& known = graph_.keyframe(id);
  if (known.image.empty()) return;
  const int width = known.image.width(), height = known.image.height();
  const int cell_px = cell_for(options_.refine_points, width, height);
  const double unit = graph_.pose(id).scale();
  for (int top = border_px; top + cell_px + border_px < height; top += cell_px) {
    for (int left = border_px; left + cell_px + border_px < width; left += cell_px) {
      int best = 0, best_x = 0, best_y = 0;
      for (int y = top; y < top + cell_px; ++y) {
        for (int x = left; x < left + cell_px; ++x) {
          if (!is_certain(known.depth, x, y)) continue;
          const int gradient = squared_gradient(known.image.view(), x, y);
          if (gradient > best) best = gradient, best_x = x, best_y = y;
        }
      }
      if (best == 0) continue;
      PhotometricPoint point{best_x, best_y, static_cast<double>(known.depth.mean.at(best_x, best_y)) / unit};
      if (is_metric_) {
        point.measured = point.inverse_depth;
        point.measured_sigma =
            measured_factor * std::sqrt(static_cast<double>(known.depth.variance.at(best_x, best_y)));
      }
      keyframes_[static_cast<std::size_t>(id)].points.push_back(point);
    }
  }
}

/// Those that a constraint connects it with, those made right before and after it among them, the nearest first.
void FinalRefinement::choose_targets() {
  std::vector<std::set<std::int32_t>> connected(keyframes_.size());
  const auto connect = [&](std::int64_t a, std::int64_t b) {
    if (graph_.keyframe(a).image.empty() || graph_.keyframe(b).image.empty()) return;
    connected[static_cast<std::size_t>(a)].insert(static_cast<std::int32_t>(b));
    connected[static_cast<std::size_t>(b)].insert(static_cast<std::int32_t>(a));
  };
  for (const Constraint& edge : graph_.edges()) connect(edge.from, edge.to);
  for (std::size_t i = 0; i < keyframes_.size(); ++i) {
    const Eigen::Vector3d here = graph_.pose(static_cast<std::int64_t>(i)).translation();
    std::vector<std::pair<double, std::int32_t>> targets;
    for (const std::int32_t other : connected[i])
      targets.emplace_back((graph_.pose(other).translation() - here).norm(), other);
    std::sort(targets.begin(), targets.end());
    for (const auto& [distance, other] : targets)
      if (static_cast<int>(keyframes_[i].targets.size()) < options_.refine_targets)
        keyframes_[i].targets.push_back(other);
  }
}

std::string FinalRefinement::run(TaskPool* pool, const std::function<bool()>& stopped, const StepsShown& shown) {
  PhotometricBundleOptions options;
  options.iterations = options_.refine_iterations;
  options.stopped = stopped;
  if (shown)
    options.begins = [&](int iteration) {
      shown("photometric adjustment, iteration", static_cast<std::size_t>(iteration),
            static_cast<std::size_t>(options_.refine_iterations));
    };
  const PhotometricBundleResult result = adjust_photometric_bundle(keyframes_, camera_, options, pool);
  better_ = result.last_cost < result.first_cost;
  if (is_metric_) scale_by_sensor();
  return fmt::format(
      "photometric adjustment of {} keyframes: cost {:.4g} -> {:.4g} in {} iterations, {} pixels compared",
      keyframes_.size(), result.first_cost, result.last_cost, result.iterations, result.residuals);
}

/// Of the points that a sensor measured.
std::vector<DepthRatio> FinalRefinement::ratios_of(std::int64_t id) const {
  std::map<std::pair<int, int>, const SensedDepth*> sensed;
  for (const SensedDepth& one : graph_.keyframe(id).sensed) sensed[{one.x, one.y}] = &one;
  std::vector<DepthRatio> ratios;
  for (const PhotometricPoint& point : keyframes_[static_cast<std::size_t>(id)].points) {
    const auto found = sensed.find({point.x, point.y});
    if (found == sensed.end()) continue;
    const SensedDepth& one = *found->second;
    ratios.push_back({static_cast<double>(one.inverse_depth), static_cast<double>(one.sigma), point.inverse_depth});
  }
  return ratios;
}

/// Images tell motion and depth up to a common scale only, one for each submap.
void FinalRefinement::scale_by_sensor() {
  std::map<int, std::vector<DepthRatio>> ratios;
  for (std::int64_t id = 0; id < graph_.size(); ++id) {
    const std::vector<DepthRatio> own = ratios_of(id);
    std::vector<DepthRatio>& all = ratios[graph_.submap(id)];
    all.insert(all.end(), own.begin(), own.end());
  }
  std::map<int, double> scales;
  for (const auto& [submap, of_submap] : ratios) scales[submap] = sensed_scale(of_submap);
  std::map<int, Eigen::Vector3d> origins;
  for (std::int64_t id = 0; id < graph_.size(); ++id) {
    SE3& camera_from_world = keyframes_[static_cast<std::size_t>(id)].camera_from_world;
    const SE3 world_from_keyframe = camera_from_world.inverse();
    const int submap = graph_.submap(id);
    const Eigen::Vector3d& origin = origins.try_emplace(submap, world_from_keyframe.translation()).first->second;
    const Eigen::Vector3d way = (world_from_keyframe.translation() - origin) / scales[submap];
    camera_from_world = SE3(world_from_keyframe.rotation(), origin + way).inverse();
  }
}

/// Of a keyframe of one camera, that its depths in the map need. nullopt where too few points tell it.
std::optional<double> FinalRefinement::scale_of(std::int64_t id) const {
  std::vector<WeightedValue> scales;
  const InverseDepthMap& depth = graph_.keyframe(id).depth;
  for (const PhotometricPoint& point : keyframes_[static_cast<std::size_t>(id)].points) {
    if (!(point.sigma > 0.0)) continue;  // It kept the depth that it had.
    const auto mean = static_cast<double>(depth.mean.at(point.x, point.y)),
               variance = static_cast<double>(depth.variance.at(point.x, point.y));
    const double sigma =
        std::sqrt(variance / (mean * mean) + point.sigma * point.sigma / (point.inverse_depth * point.inverse_depth));
    // A median is most certain with the inverse of sigmas, as a mean is with that of variances.
    scales.push_back({mean / point.inverse_depth, 1.0 / sigma});
  }
  if (scales.size() < least_points) return std::nullopt;
  return weighted_median(std::move(scales));
}

std::vector<Sim3> FinalRefinement::poses() const {
  std::vector<Sim3> poses;
  for (std::int64_t id = 0; id < graph_.size(); ++id) {
    const SE3 world_from_keyframe = keyframes_[static_cast<std::size_t>(id)].camera_from_world.inverse();
    const double before = graph_.pose(id).scale();
    const double scale = is_metric_ ? before : scale_of(id).value_or(before);
    poses.emplace_back(scale, world_from_keyframe.rotation(), world_from_keyframe.translation());
  }
  return poses;
}

}  // namespace rastro
