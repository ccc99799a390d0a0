// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/window_bundle.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "rastro/multiview/absolute_pose.h"
#include "rastro/multiview/essential.h"
#include "rastro/multiview/triangulation.h"

namespace rastro {
namespace {

constexpr std::size_t most_views = 8, least_views = 5, least_points = 40;
// Wide: with a wrong calibration the scene is not rigid.
constexpr double rigid_error_px = 3.0, largest_error_px = 3.0, least_parallax_deg = 0.3;
constexpr int adjustments = 2;
constexpr RefinementOptions refinement{.iterations = 12, .huber_px = 1.0};

/// By view, the rays of the features in it.
using Rays = std::vector<std::vector<Eigen::Vector2d>>;

/// Of the features that were followed to the end, in some frames of the window, the first and the last among them.
Rays followed_rays(const TrackedWindow& window, const Camera& camera) {
  const std::size_t count = std::min(most_views, window.frames);
  Rays views(count);
  for (const std::size_t i : window.survivors()) {
    std::vector<Eigen::Vector2d> rays;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t frame = k * (window.frames - 1) / (count - 1);
      const auto ray = camera.unproject(window.tracks[i][frame].cast<double>());
      if (ray) rays.push_back(*ray);
    }
    if (rays.size() < count) continue;
    for (std::size_t k = 0; k < count; ++k) views[k].push_back(rays[k]);
  }
  return views;
}

/// The points that the first and the last view agree on, and which features they are.
struct Points {
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::size_t> features;
};

Points points_of(const Rays& views, const EssentialFit& motion, double focal_px) {
  Points points;
  for (std::size_t i = 0; i < motion.is_inlier.size(); ++i) {
    if (motion.is_inlier[i] == 0) continue;
    const auto point = triangulate(motion.second_from_first, views.front()[i], views.back()[i],
                                   {.focal_px = focal_px, .max_error_px = largest_error_px, .min_parallax_deg = 0.02});
    if (!point) continue;
    points.positions.push_back(point->position);
    points.features.push_back(i);
  }
  return points;
}

/// The camera between the first and the last view; nullopt if the points say nothing about it.
std::optional<SE3> pose_of(const Points& points, const std::vector<Eigen::Vector2d>& rays, const SE3& guess,
                           double focal_px) {
  AbsolutePoseOptions options;
  options.max_error_px = 2.0 * rigid_error_px;
  options.max_iterations = 60;
  options.focal_px = focal_px;
  std::vector<Eigen::Vector2d> seen;
  for (const std::size_t feature : points.features) seen.push_back(rays[feature]);
  const auto pose = estimate_absolute_pose(points.positions, seen, options, guess);
  if (!pose) return std::nullopt;
  return pose->camera_from_world;
}

void drop_outliers(RefinementWindow& window) {
  std::vector<std::uint8_t> out(window.points.size(), 0);
  for (const WindowObservation& seen : window.observations) {
    const double error_px =
        reprojection_error_px(window.camera_from_world[static_cast<std::size_t>(seen.camera)],
                              window.points[static_cast<std::size_t>(seen.point)], seen.ray, window.focal_px);
    if (error_px > largest_error_px) out[static_cast<std::size_t>(seen.point)] = 1;
  }
  std::erase_if(window.observations,
                [&](const WindowObservation& seen) { return out[static_cast<std::size_t>(seen.point)] != 0; });
}

}  // namespace

std::optional<RefinementWindow> adjusted_bundle(const TrackedWindow& window, const Camera& camera) {
  if (window.frames < least_views) return std::nullopt;
  const Rays views = followed_rays(window, camera);
  RefinementWindow bundle;
  bundle.focal_px = 0.5 * (camera.fx + camera.fy);
  CalibratedRansacOptions options;
  options.max_error_px = rigid_error_px;
  options.max_iterations = 100;
  options.focal_px = bundle.focal_px;
  if (views.front().size() < least_points) return std::nullopt;
  const auto motion = estimate_essential(views.front(), views.back(), options);
  if (!motion || motion->median_parallax_deg < least_parallax_deg) return std::nullopt;
  const Points points = points_of(views, *motion, bundle.focal_px);
  if (points.positions.size() < least_points) return std::nullopt;
  const std::size_t last = views.size() - 1;
  for (std::size_t k = 0; k <= last; ++k) {
    const auto pose = k == 0      ? SE3()
                      : k == last ? std::optional<SE3>(motion->second_from_first)
                                  : pose_of(points, views[k], bundle.camera_from_world.back(), bundle.focal_px);
    if (!pose) return std::nullopt;
    bundle.camera_from_world.push_back(*pose);
    bundle.fixed.push_back(k == 0 ? 1 : 0);
  }
  bundle.points = points.positions;
  for (std::size_t i = 0; i < points.features.size(); ++i)
    for (std::size_t k = 0; k <= last; ++k)
      bundle.observations.push_back({static_cast<int>(k), static_cast<int>(i), views[k][points.features[i]]});
  for (int k = 0; k < adjustments; ++k) {
    refine_window(bundle, refinement);
    drop_outliers(bundle);
  }
  if (bundle.observations.size() < least_points * views.size()) return std::nullopt;
  return bundle;
}

}  // namespace rastro
