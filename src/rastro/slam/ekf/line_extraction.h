// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/sensor/laser_scan.h"
#include "rastro/slam/ekf/options.h"

namespace rastro {

/// A return of a scan, in the laser frame.
struct ScanPoint {
  Eigen::Vector2d position;
  double range = 0.0;
  std::size_t beam = 0;
};

/// The returns within `max_beam_m`, split where two neighbors are too far apart to lie on the same surface. Each run is
/// in the order of the beams. A surface that lies across the first and last beam of a 360-degree scan is split there.
std::vector<std::vector<ScanPoint>> runs_of(const LaserScan& scan, const EkfOptions& options);

/// A straight piece of wall in one run.
struct ScanLine {
  std::size_t first = 0, last = 0;  ///< Its outermost points in the run.
  Eigen::Vector2d center;           ///< Mean of its points.
  Eigen::Vector2d direction;        ///< Unit vector, from first to last.
  /// Of the offset across the line at the center (m) and the rotation about the center (rad), from the beams' noise.
  Eigen::Matrix2d covariance;

  Eigen::Vector2d normal() const { return {-direction.y(), direction.x()}; }
  double distance(const Eigen::Vector2d& point) const { return normal().dot(point - center); }
};

/// The total-least-squares line through the points first to last of a run. Points farther from it than
/// `line_tolerance_m` are left out. The covariance comes from the noise along the beams. Needs at least two different
/// points.
ScanLine fit_line(std::span<const ScanPoint> run, std::size_t first, std::size_t last, const EkfOptions& options);

/// Lines of a run by RANSAC (Fischler and Bolles 1981): the one with most points first, then those before and after it;
/// sorted along the run. A sample is two nearby returns. Its inliers are the consecutive points around it that stay
/// within `line_tolerance_m`, except for single outliers.
std::vector<ScanLine> extract_lines(std::span<const ScanPoint> run, std::size_t reach_beams, const EkfOptions& options,
                                    Random& random);

}  // namespace rastro
