// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/consistency_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace rastro {
namespace {

constexpr double stretch_m = 1.0, stretch_rad = std::numbers::pi / 4.0;
constexpr std::size_t fewest_stretches = 8, most_stretches = 100;
/// The largest quarter: a place that is recognized within a stretch corrects the drift of the whole way at once.
constexpr double left_out = 0.25, quantile_of_square = 1.323;  // of a normal distribution
/// Usual wheels reach 2, on floors and in turns where they are worse than elsewhere.
constexpr double clearly_more = 3.0;

void add(std::deque<double>& squares, double difference, double variance) {
  if (!(variance > 0.0)) return;
  squares.push_back(difference * difference / variance);
  if (squares.size() > most_stretches) squares.pop_front();
}

/// By this standard deviations are larger than set.
double factor_of(const std::deque<double>& squares) {
  if (squares.size() < fewest_stretches) return 1.0;
  std::vector<double> sorted(squares.begin(), squares.end());
  std::sort(sorted.begin(), sorted.end());
  const auto kept = static_cast<std::size_t>((1.0 - left_out) * static_cast<double>(sorted.size()));
  return std::sqrt(sorted[kept] / quantile_of_square);
}

}  // namespace

void ConsistencyCheck::move(const Motion& motion) {
  odometry_.last_from_body = odometry_.last_from_body * motion.last_from_body;
  odometry_.covariance += motion.covariance;
  path_m_ += motion.last_from_body.translation().norm();
  path_rad_ += std::abs(motion.last_from_body.rotation().angle());
}

void ConsistencyCheck::end_frame(const SE2& world_from_body, bool told) {
  const bool complete = path_m_ >= stretch_m || path_rad_ >= stretch_rad;
  if (!told || (start_ && !complete)) return;
  // Over a much longer one errors of the heading have become errors of the position.
  if (start_ && path_m_ < 2.0 * stretch_m && path_rad_ < 2.0 * stretch_rad)
    compare(start_->inverse() * world_from_body);
  start_ = world_from_body;
  odometry_ = {};
  path_m_ = path_rad_ = 0.0;
}

void ConsistencyCheck::compare(const SE2& start_from_body) {
  const SE2& by_odometry = odometry_.last_from_body;
  add(yaw_, (start_from_body.inverse() * by_odometry).rotation().angle(), odometry_.covariance(2, 2));
  // Along the path, where errors of the heading count least.
  const Eigen::Vector2d path = by_odometry.translation();
  if (path.norm() > 0.5 * stretch_m)
    add(along_path_, path.normalized().dot(start_from_body.translation() - path), odometry_.covariance(0, 0));
  const double now = std::max(factor_of(along_path_), factor_of(yaw_));
  if (now > clearly_more) factor_ = std::max(factor_, now);
}

}  // namespace rastro
