// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/cloud/upright.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

namespace rastro {
namespace {

using Eigen::Vector3d;

constexpr double farthest_tilt_deg = 40.0;  ///< Of the cameras' mean y axis from vertical.
constexpr std::size_t fewest_points = 200;  ///< Minimum number of points that define up.
constexpr double bin_m = 0.02;
constexpr double large_share = 0.25;  ///< Minimum size relative to the largest level plane below the cameras.
constexpr double below_m = 0.2;       ///< Minimum height of the cameras above the floor.
constexpr double deepest_m = 1000.0;  ///< Below the cameras; what lies deeper is an error.

double cosine(double degrees) { return std::cos(degrees * std::numbers::pi / 180.0); }

Vector3d mean_up(const Trajectory& cameras) {
  Vector3d sum = Vector3d::Zero();
  for (const StampedPose& pose : cameras) sum -= pose.world_from_body.rotation() * Vector3d::UnitY();
  if (sum.norm() > 0.1 * static_cast<double>(cameras.size())) return sum.normalized();
  return cameras.empty() ? Vector3d(-Vector3d::UnitY())
                         : Vector3d(-(cameras.front().world_from_body.rotation() * Vector3d::UnitY()));
}

/// The mean of the normals near the initial direction.
std::optional<Vector3d> refined_up(const PointCloud& cloud, Vector3d up) {
  for (const double within_deg : {farthest_tilt_deg, 25.0, 15.0, 10.0, 7.0, 5.0, 5.0}) {
    const double least = cosine(within_deg);
    Vector3d sum = Vector3d::Zero();
    std::size_t count = 0;
    for (const CloudPoint& point : cloud.points) {
      const Vector3d normal = point.normal.cast<double>();
      if (normal.dot(up) < least) continue;
      sum += normal;
      ++count;
    }
    if (count < fewest_points) return std::nullopt;
    up = sum.normalized();
  }
  return up;
}

bool is_level(const CloudPoint& point, const Vector3d& up) {
  return point.normal.cast<double>().dot(up) > cosine(12.0);
}

/// Height of the lowest level plane that is not much smaller than the largest one.
std::optional<double> floor_height(const PointCloud& cloud, const Vector3d& up, double highest) {
  double lowest = highest;
  for (const CloudPoint& point : cloud.points)
    if (is_level(point, up)) lowest = std::min(lowest, point.position.cast<double>().dot(up));
  lowest = std::max(lowest, highest - deepest_m);
  const auto bins = static_cast<std::size_t>((highest - lowest) / bin_m);
  std::vector<std::size_t> counts(bins + 2, 0);
  for (const CloudPoint& point : cloud.points) {
    const double height = point.position.cast<double>().dot(up);
    if (is_level(point, up) && height >= lowest && height < highest)
      ++counts[static_cast<std::size_t>((height - lowest) / bin_m)];
  }
  std::vector<std::size_t> near(counts.size(), 0);
  for (std::size_t k = 1; k + 1 < counts.size(); ++k) near[k] = counts[k - 1] + counts[k] + counts[k + 1];
  const std::size_t largest = *std::max_element(near.begin(), near.end());
  if (largest < fewest_points) return std::nullopt;
  for (std::size_t k = 1; k + 1 < near.size(); ++k) {
    const bool peak = near[k] >= near[k + 1];
    if (peak && static_cast<double>(near[k]) >= large_share * static_cast<double>(largest))
      return lowest + bin_m * (static_cast<double>(k) + 0.5);
  }
  return std::nullopt;
}

struct Plane {
  Vector3d up;
  double height = 0.0;  ///< Of its points along `up`.
};

/// Least squares over the points near it, a few times.
Plane refined(const PointCloud& cloud, Plane plane) {
  for (int round = 0; round < 3; ++round) {
    Vector3d sum = Vector3d::Zero();
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    std::size_t count = 0;
    for (const CloudPoint& point : cloud.points) {
      const Vector3d position = point.position.cast<double>();
      if (!is_level(point, plane.up) || std::abs(position.dot(plane.up) - plane.height) > 0.04) continue;
      sum += position;
      squares += position * position.transpose();
      ++count;
    }
    if (count < fewest_points / 2) return plane;
    const Vector3d mean = sum / static_cast<double>(count);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(squares / static_cast<double>(count) -
                                                              mean * mean.transpose());
    Vector3d up = axes.eigenvectors().col(0);
    if (up.dot(plane.up) < 0.0) up = -up;
    if (up.dot(plane.up) < cosine(8.0)) return plane;
    plane = {up, mean.dot(up)};
  }
  return plane;
}

SE3 frame_of(const Vector3d& up, const Vector3d& origin, const SE3& world_from_first) {
  Vector3d ahead = world_from_first.rotation() * Vector3d::UnitZ();
  ahead -= up * up.dot(ahead);
  if (ahead.norm() < 0.1) {  // it faces straight down or up
    ahead = world_from_first.rotation() * -Vector3d::UnitY();
    ahead -= up * up.dot(ahead);
  }
  Eigen::Matrix3d axes;
  axes.col(0) = ahead.normalized();
  axes.col(1) = up.cross(axes.col(0));
  axes.col(2) = up;
  return SE3(SO3::from_matrix(axes), origin).inverse();
}

}  // namespace

Upright find_upright(const PointCloud& cloud, const Trajectory& cameras) {
  const SE3 first = cameras.empty() ? SE3() : cameras.front().world_from_body;
  const Vector3d guess = mean_up(cameras);
  Upright found;
  found.upright_from_world = frame_of(guess, first.translation(), first);
  found.found_by = "no floor was found: up is the mean of the cameras' up, heights count from the first camera";
  const auto up = refined_up(cloud, guess);
  if (!up) return found;
  std::vector<double> heights;
  for (const StampedPose& pose : cameras) heights.push_back(pose.world_from_body.translation().dot(*up));
  std::sort(heights.begin(), heights.end());
  const double camera = heights.empty() ? 0.0 : heights[heights.size() / 2];
  const auto height = floor_height(cloud, *up, camera - below_m);
  if (!height) return found;
  const Plane floor = refined(cloud, {*up, *height});
  const Vector3d origin = first.translation() - floor.up * (first.translation().dot(floor.up) - floor.height);
  found.upright_from_world = frame_of(floor.up, origin, first);
  found.floor_found = true;
  found.found_by = fmt::format("heights count from the lowest large level plane, {:.2f} m below the first camera",
                               first.translation().dot(floor.up) - floor.height);
  return found;
}

}  // namespace rastro
