// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/ground_plane.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace rastro {
namespace {

constexpr double radians = std::numbers::pi / 180.0;

std::vector<Eigen::Vector3d> below_horizon(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& down,
                                           double min_depression_deg) {
  std::vector<Eigen::Vector3d> below;
  const double least = std::sin(min_depression_deg * radians);
  for (const Eigen::Vector3d& p : points) {
    const double depth = down.dot(p);
    if (p.allFinite() && p.z() > 0.0 && depth > 0.0 && depth >= least * p.norm()) below.push_back(p);
  }
  return below;
}

double vote(double log_ratio, double kernel) { return std::exp(-0.5 * (log_ratio / kernel) * (log_ratio / kernel)); }

/// The height with most votes. Votes are of ratios of heights, so that the unit does not matter.
double densest_height(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& down, double kernel) {
  std::vector<double> logs;
  for (const Eigen::Vector3d& p : points) logs.push_back(std::log(down.dot(p)));
  std::sort(logs.begin(), logs.end());
  double best = 0.0, best_votes = -1.0;
  std::size_t first = 0;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    while (logs[first] < logs[i] - 3.0 * kernel) ++first;
    double votes = 0.0;
    for (std::size_t k = first; k < logs.size() && logs[k] <= logs[i] + 3.0 * kernel; ++k) {
      votes += vote(logs[k] - logs[i], kernel);
    }
    if (votes > best_votes) {
      best_votes = votes;
      best = logs[i];
    }
  }
  return std::exp(best);
}

/// The plane plane.dot(p) = 1 is `down` / height for level ground.
double log_height_ratio(const Eigen::Vector3d& plane, const Eigen::Vector3d& point) {
  const double ratio = plane.dot(point);
  return ratio > 0.0 ? std::log(ratio) : -1e3;
}

/// Moves the height to the middle of the votes around it.
Eigen::Vector3d height_refined(Eigen::Vector3d plane, const std::vector<Eigen::Vector3d>& points, double kernel) {
  for (int i = 0; i < 10; ++i) {
    double sum = 0.0, weights = 0.0;
    for (const Eigen::Vector3d& p : points) {
      const double ratio = log_height_ratio(plane, p), weight = vote(ratio, kernel);
      sum += weight * ratio;
      weights += weight;
    }
    if (!(weights > 0.0)) break;
    plane *= std::exp(-sum / weights);
  }
  return plane;
}

/// The plane through the votes around it, any way it leans; nullopt where the points leave that open.
std::optional<Eigen::Vector3d> plane_refined(Eigen::Vector3d plane, const std::vector<Eigen::Vector3d>& points,
                                             double kernel) {
  for (int i = 0; i < 10; ++i) {
    // Errors are relative, as the errors of triangulated heights are: each point's equation is divided by its height.
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : points) {
      const double weight = vote(log_height_ratio(plane, p), kernel);
      normal += weight * p * p.transpose();
      right += weight * p;
    }
    const Eigen::LDLT<Eigen::Matrix3d> solver(normal);
    if (!(solver.vectorD().minCoeff() > 1e-6 * solver.vectorD().maxCoeff())) return std::nullopt;
    plane = solver.solve(right);
    if (!plane.allFinite() || !(plane.norm() > 0.0)) return std::nullopt;
  }
  return plane;
}

}  // namespace

std::optional<GroundHeight> estimate_ground_height(std::span<const Eigen::Vector3d> points_in_camera,
                                                   const GroundHeightOptions& options) {
  const Eigen::Vector3d down(0.0, std::cos(options.pitch_rad), std::sin(options.pitch_rad));
  const auto points = below_horizon(points_in_camera, down, options.min_depression_deg);
  if (points.empty() || static_cast<int>(points.size()) < options.min_support) return std::nullopt;
  Eigen::Vector3d plane = down / densest_height(points, down, options.kernel);
  plane = height_refined(plane, points, options.kernel);
  if (options.max_tilt_deg > 0.0) {
    const auto leaning = plane_refined(plane, points, options.kernel);
    if (leaning && leaning->normalized().dot(down) >= std::cos(options.max_tilt_deg * radians)) plane = *leaning;
  }
  GroundHeight result;
  result.height = 1.0 / plane.norm();
  result.normal = plane.normalized();
  result.support = static_cast<int>(std::count_if(points.begin(), points.end(), [&](const Eigen::Vector3d& p) {
    return std::abs(log_height_ratio(plane, p)) <= 3.0 * options.kernel;
  }));
  result.share = static_cast<double>(result.support) / static_cast<double>(points.size());
  return result.support < options.min_support ? std::nullopt : std::optional(result);
}

}  // namespace rastro
