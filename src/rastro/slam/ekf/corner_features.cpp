// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/corner_features.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace rastro {
namespace {

constexpr double radians_per_degree = std::numbers::pi / 180.0;

Eigen::Matrix2d normals_of(const ScanLine& a, const ScanLine& b) {
  return (Eigen::Matrix2d() << a.normal().transpose(), b.normal().transpose()).finished();
}

/// The intersection of the lines, if they form a corner there.
std::optional<Eigen::Vector2d> corner_of(std::span<const ScanPoint> run, const ScanLine& a, const ScanLine& b,
                                         const EkfOptions& options) {
  const double sine = a.direction.x() * b.direction.y() - a.direction.y() * b.direction.x();
  if (std::abs(sine) < std::sin(options.min_corner_deg * radians_per_degree)) return std::nullopt;
  const Eigen::Vector2d offsets(a.normal().dot(a.center), b.normal().dot(b.center));
  const Eigen::Vector2d crossing = normals_of(a, b).inverse() * offsets;
  // The last beam on a wall ends up to one step before the corner.
  const double step_a = (run[a.last].position - run[a.last - 1].position).norm();
  const double step_b = (run[b.first + 1].position - run[b.first].position).norm();
  const bool seen = (run[a.last].position - crossing).norm() <= options.corner_gap_m + step_a &&
                    (run[b.first].position - crossing).norm() <= options.corner_gap_m + step_b;
  return seen ? std::optional(crossing) : std::nullopt;
}

/// Ends both lines at the intersection: points beyond it belong to the other line.
void part_at(const Eigen::Vector2d& crossing, std::span<const ScanPoint> run, ScanLine& a, ScanLine& b,
             const EkfOptions& options) {
  const auto before = [&](const ScanLine& line, std::size_t point) {
    return line.direction.dot(run[point].position - crossing) < 0.0;
  };
  const auto is_on = [&](const ScanLine& line, std::size_t point) {
    return std::abs(line.distance(run[point].position)) <= options.line_tolerance_m;
  };
  // A point near the corner is on both lines; it goes to the nearer one.
  const auto of_a = [&](std::size_t point) {
    return before(a, point) &&
           (before(b, point) || std::abs(a.distance(run[point].position)) <= std::abs(b.distance(run[point].position)));
  };
  std::size_t last = a.last, first = b.first;
  while (last > a.first + 2 && !of_a(last)) --last;
  while (last + 1 < b.last - 2 && of_a(last + 1) && is_on(a, last + 1)) ++last;
  first = std::max(first, last + 1);
  while (first > last + 1 && is_on(b, first - 1) && !of_a(first - 1)) --first;
  a = fit_line(run, a.first, last, options);
  b = fit_line(run, first, b.last, options);
}

ScanFeature feature_at(const Eigen::Vector2d& crossing, const ScanLine& a, const ScanLine& b,
                       const EkfOptions& options) {
  const auto variance_at = [&](const ScanLine& line) {
    const Eigen::Vector2d lever(1.0, line.direction.dot(crossing - line.center));
    return lever.dot(line.covariance * lever);
  };
  const Eigen::Matrix2d position_by_offsets = normals_of(a, b).inverse();
  const Eigen::Vector2d variances(variance_at(a), variance_at(b));
  const Eigen::Vector2d between = b.direction - a.direction;
  return {crossing,
          position_by_offsets * variances.asDiagonal() * position_by_offsets.transpose() +
              options.corner_error_m * options.corner_error_m * Eigen::Matrix2d::Identity(),
          std::atan2(between.y(), between.x())};
}

bool is_background(const LaserScan& scan, std::size_t beam, double range, const EkfOptions& options) {
  if (scan.is_free(beam)) return true;
  return scan.is_return(beam) && static_cast<double>(scan.ranges[beam]) >= range + options.spike_depth_m;
}

std::optional<ScanFeature> spike_of(const LaserScan& scan, std::span<const ScanPoint> run, const EkfOptions& options) {
  const auto count = static_cast<int>(run.size());
  const std::size_t before = run.front().beam, after = run.back().beam + 1;
  if (count < options.min_spike_beams || count > options.max_spike_beams) return std::nullopt;
  if (before == 0 || after >= scan.ranges.size()) return std::nullopt;
  double range = 0.0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  for (const ScanPoint& point : run) {
    range += point.range / count;
    position += point.position / count;
  }
  const double width = (run.back().position - run.front().position).norm() + std::abs(scan.angle_step) * range;
  if (range > options.max_spike_range_m || width > options.max_spike_m) return std::nullopt;
  if (!is_background(scan, before - 1, range, options) || !is_background(scan, after, range, options)) {
    return std::nullopt;
  }
  const Eigen::Vector2d away = position.normalized(), across(-away.y(), away.x());
  // Averaged over the width of a round pole, its surface is pi/4 of the radius in front of the center.
  position += std::numbers::pi / 8.0 * width * away;
  const double step = std::abs(scan.angle_step) * range;
  const double along = options.beam_noise_m * options.beam_noise_m / count + step * step / 12.0;
  const double sideways = step * step / 12.0;
  return ScanFeature{position,
                     along * away * away.transpose() + sideways * across * across.transpose() +
                         options.spike_error_m * options.spike_error_m * Eigen::Matrix2d::Identity(),
                     0.0};
}

}  // namespace

std::vector<ScanFeature> find_corners(std::span<const ScanPoint> run, std::vector<ScanLine> lines,
                                      const EkfOptions& options) {
  constexpr int rounds = 2;  // Better lines give a better intersection.
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
      const auto corner = corner_of(run, lines[i], lines[i + 1], options);
      if (corner) part_at(*corner, run, lines[i], lines[i + 1], options);
    }
  }
  std::vector<ScanFeature> features;
  for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
    const auto corner = corner_of(run, lines[i], lines[i + 1], options);
    if (corner) features.push_back(feature_at(*corner, lines[i], lines[i + 1], options));
  }
  return features;
}

std::vector<ScanFeature> find_spikes(const LaserScan& scan, std::span<const std::vector<ScanPoint>> runs,
                                     const EkfOptions& options) {
  std::vector<ScanFeature> features;
  for (const auto& run : runs) {
    const auto spike = spike_of(scan, run, options);
    if (spike) features.push_back(*spike);
  }
  return features;
}

}  // namespace rastro
