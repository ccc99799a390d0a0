// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/motion_residual.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "rastro/multiview/absolute_pose.h"
#include "rastro/multiview/essential.h"
#include "rastro/multiview/rotation.h"
#include "rastro/multiview/triangulation.h"

namespace rastro {
namespace {

constexpr std::size_t least_rays = 40;
constexpr double least_share = 0.6;  // Of the features, with rays and depth.
constexpr double outlier_px = 4.0;   // What an outlier counts at most.
constexpr double rotation_px = 1.0;  // A median error below: the camera only rotated.
constexpr double sample_error_px = 1.5;

/// The same features in three frames, normalized; depths are 0 where unknown.
struct ThreeViews {
  std::vector<Eigen::Vector2d> first, middle, last;
  std::vector<double> depths, mirrored_depths;
};

std::optional<Eigen::Vector2d> ray_of(const Camera& camera, const Eigen::Vector2f& pixel) {
  return camera.unproject(pixel.cast<double>());
}

ThreeViews views_of(const TrackedWindow& window, const Camera& camera) {
  ThreeViews views;
  for (const std::size_t i : window.survivors()) {
    const auto& track = window.tracks[i];
    const auto first = ray_of(camera, track.front()), middle = ray_of(camera, track[track.size() / 2]),
               last = ray_of(camera, track.back());
    if (!first || !middle || !last) continue;
    views.first.push_back(*first);
    views.middle.push_back(*middle);
    views.last.push_back(*last);
    views.depths.push_back(static_cast<double>(window.first_depths[i]));
    views.mirrored_depths.push_back(static_cast<double>(window.mirrored_depths[i]));
  }
  return views;
}

double robust_rms(const std::vector<double>& errors_px) {
  double sum = 0.0;
  for (const double error : errors_px) sum += std::min(error * error, outlier_px * outlier_px);
  return std::sqrt(sum / static_cast<double>(errors_px.size()));
}

AbsolutePoseOptions pose_options(double focal_px) {
  AbsolutePoseOptions options;
  options.max_error_px = 2.0 * sample_error_px;
  options.max_iterations = 60;
  options.focal_px = focal_px;
  return options;
}

double reprojection_px(const SE3& pose, const Eigen::Vector3d& point, const Eigen::Vector2d& ray, double focal_px) {
  const Eigen::Vector3d p = pose * point;
  if (p.z() < 1e-6) return outlier_px;
  return focal_px * (p.hnormalized() - ray).norm();
}

/// Points with depth in the first frame, posed in the last one.
std::optional<double> depth_residual(const ThreeViews& views, double focal_px) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> rays;
  for (std::size_t i = 0; i < views.first.size(); ++i) {
    if (!(views.depths[i] > 0.0)) continue;
    points.push_back(views.depths[i] * views.first[i].homogeneous());
    rays.push_back(views.last[i]);
  }
  if (points.size() < least_rays) return std::nullopt;
  const auto pose = estimate_absolute_pose(points, rays, pose_options(focal_px), SE3());
  if (!pose) return outlier_px;
  std::vector<double> errors;
  for (std::size_t i = 0; i < points.size(); ++i)
    errors.push_back(reprojection_px(pose->camera_from_world, points[i], rays[i], focal_px));
  return robust_rms(errors);
}

double rotation_residual(const ThreeViews& views, const RotationFit& fit, double focal_px) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < views.first.size(); ++i)
    errors.push_back(reprojection_px(SE3(fit.second_from_first, Eigen::Vector3d::Zero()), views.first[i].homogeneous(),
                                     views.last[i], focal_px));
  return robust_rms(errors);
}

double three_view_residual(const ThreeViews& views, double focal_px) {
  CalibratedRansacOptions options;
  options.max_error_px = sample_error_px;
  options.max_iterations = 100;
  options.focal_px = focal_px;
  const auto motion = estimate_essential(views.first, views.last, options);
  if (!motion) return outlier_px;
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> rays;
  for (std::size_t i = 0; i < views.first.size(); ++i) {
    if (!motion->is_inlier[i]) continue;
    const auto point = triangulate(motion->second_from_first, views.first[i], views.last[i],
                                   {.focal_px = focal_px, .max_error_px = outlier_px, .min_parallax_deg = 0.02});
    if (!point) continue;
    points.push_back(point->position);
    rays.push_back(views.middle[i]);
  }
  if (points.size() < least_rays / 2) return outlier_px;
  const auto pose = estimate_absolute_pose(points, rays, pose_options(focal_px), SE3());
  if (!pose) return outlier_px;
  std::vector<double> errors(views.first.size() - points.size(), outlier_px);
  for (std::size_t i = 0; i < points.size(); ++i)
    errors.push_back(reprojection_px(pose->camera_from_world, points[i], rays[i], focal_px));
  return robust_rms(errors);
}

}  // namespace

std::optional<double> motion_residual(const TrackedWindow& window, const Camera& camera) {
  const ThreeViews views = views_of(window, camera);
  const auto least = least_share * static_cast<double>(window.survivors().size());
  if (views.first.size() < least_rays || static_cast<double>(views.first.size()) < least) return std::nullopt;
  const double focal_px = 0.5 * (camera.fx + camera.fy);
  if (const auto residual = depth_residual(views, focal_px)) return residual;
  CalibratedRansacOptions options;
  options.max_error_px = sample_error_px;
  options.focal_px = focal_px;
  const auto rotation = rotation_between(views.first, views.last, options);
  if (rotation && rotation->median_error_px < rotation_px) return rotation_residual(views, *rotation, focal_px);
  return three_view_residual(views, focal_px);
}

std::optional<MirrorResiduals> mirror_residuals(const TrackedWindow& window, const Camera& camera) {
  ThreeViews views = views_of(window, camera);
  for (std::size_t i = 0; i < views.depths.size(); ++i)
    if (!(views.depths[i] > 0.0) || !(views.mirrored_depths[i] > 0.0)) views.depths[i] = views.mirrored_depths[i] = 0.0;
  const double focal_px = 0.5 * (camera.fx + camera.fy);
  const auto given = depth_residual(views, focal_px);
  std::swap(views.depths, views.mirrored_depths);
  const auto mirrored = depth_residual(views, focal_px);
  if (!given || !mirrored) return std::nullopt;
  return MirrorResiduals{*given, *mirrored};
}

}  // namespace rastro
