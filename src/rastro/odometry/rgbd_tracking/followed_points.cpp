// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/followed_points.h"

#include <utility>

#include "rastro/odometry/rgbd_tracking/coverage.h"

namespace rastro {
namespace {

// A point tracked by optical flow alone has drifted since its first observation.
constexpr double carried_sigma_factor = 2.0;

PointMeasurement measurement_of(const FoundPoint& found, const PointMap& map, double pixel_sigma) {
  const MapPoint& point = map.points[found.point];
  PointMeasurement measured;
  measured.in_world = map.in_world(point);
  const Eigen::Vector3d along = map.world_from_anchor(point).rotation() * Eigen::Vector3d(point.ray.homogeneous());
  measured.in_world_per_inverse_depth = -along / (point.inverse_depth * point.inverse_depth);
  measured.inverse_depth_variance = 1.0 / point.information;
  measured.map_per_second = point.per_second;
  measured.ray = found.ray;
  measured.ray_sigma = pixel_sigma * (found.recognized ? 1.0 : carried_sigma_factor);
  return measured;
}

}  // namespace

void FollowedPoints::take(std::vector<FoundPoint> found, const PointMap& map, double noise_factor) {
  found_ = std::move(found);
  measured_.clear();
  for (const FoundPoint& point : found_)
    measured_.push_back(measurement_of(point, map, noise_factor * options_.pixel_sigma / camera_.fx));
}

void FollowedPoints::clear() {
  found_.clear();
  measured_.clear();
}

void FollowedPoints::read_depths(const Frame& frame, const Vector6d& velocity, const DelayedDepth& depth) {
  if (frame.depth.empty()) return;
  for (PointMeasurement& point : measured_) {
    const auto reading = depth.read(frame, point.ray, velocity);
    if (!reading) continue;
    point.per_second = reading->per_second;
    point.inverse_depth = reading->inverse_depth;
    point.inverse_depth_sigma = reading->sigma;
  }
}

std::vector<std::uint8_t> FollowedPoints::fitting(const SE3& pose, double within_px) const {
  const SE3 camera_from_world = pose.inverse();
  std::vector<std::uint8_t> fits(measured_.size(), 0);
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    const Eigen::Vector3d p = camera_from_world * measured_[i].in_world;
    fits[i] = p.z() > 0.0 && (p.head<2>() / p.z() - measured_[i].ray).norm() * camera_.fx <= within_px;
  }
  return fits;
}

double FollowedPoints::keep_inliers(const SE3& pose, PointMap& map, std::vector<FollowedFeature>& features) {
  const std::vector<std::int32_t> weights = coverage_weights(found_, camera_);
  const std::vector<std::uint8_t> fits = fitting(pose, options_.max_error_px);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < found_.size(); ++i) {
    features.push_back(
        {found_[i].pixel, fits[i] != 0 ? FollowedFeature::State::inlier : FollowedFeature::State::outlier});
    if (fits[i] != 0) {
      found_[kept] = found_[i];
      measured_[kept++] = measured_[i];
    } else {
      map.points[found_[i].point].tracked = false;
      ++map.points[found_[i].point].missed;
    }
  }
  found_.resize(kept);
  measured_.resize(kept);
  return weighted_share(weights, fits);
}

void FollowedPoints::teach_depths(const SE3& pose, PointMap& map) const {
  for (std::size_t i = 0; i < found_.size(); ++i) {
    MapPoint& point = map.points[found_[i].point];
    ++point.seen;
    if (!(measured_[i].inverse_depth > 0.0)) continue;
    const SE3 anchor_from_camera = map.world_from_anchor(point).inverse() * pose;
    const Eigen::Vector3d p = anchor_from_camera * Eigen::Vector3d(Eigen::Vector3d(measured_[i].ray.homogeneous()) /
                                                                   measured_[i].inverse_depth);
    if (p.z() < options_.min_depth_m) continue;
    PointMap::add_reading(point, {1.0 / p.z(), measured_[i].inverse_depth_sigma, measured_[i].per_second});
  }
}

}  // namespace rastro
