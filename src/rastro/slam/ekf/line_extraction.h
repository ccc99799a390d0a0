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
  Eigen::Vector2d place;
  double range = 0.0;
  std::size_t beam = 0;
};

/// The returns within `max_beam_m`, cut where two neighbours lie so far apart that they are of different things; each
/// run in the order of the beams. A thing that lies across the first and last beam of a full turn is cut there.
std::vector<std::vector<ScanPoint>> runs_of(const LaserScan& scan, const EkfOptions& options);

/// A straight piece of wall in one run.
struct ScanLine {
  std::size_t first = 0, last = 0;  ///< Its outermost points in the run.
  Eigen::Vector2d centre;           ///< Mean of its points.
  Eigen::Vector2d direction;        ///< Unit vector, from first to last.
  /// Of the offset across the line at the centre (m) and the turn about it (rad), from the beams' noise.
  Eigen::Matrix2d covariance;

  Eigen::Vector2d normal() const { return {-direction.y(), direction.x()}; }
  double distance(const Eigen::Vector2d& point) const { return normal().dot(point - centre); }
};

/// The line of least squared distances through the points first to last of a run, without those farther from it than
/// `line_tolerance_m`, and with the covariance that noise along the beams gives it. At least two different points.
ScanLine fit_line(std::span<const ScanPoint> run, std::size_t first, std::size_t last, const EkfOptions& options);

/// Lines of a run by RANSAC (Fischler and Bolles 1981), the one with most points first, then the others before and
/// after it; sorted along the run. A sample is two near returns; its points are the stretch around it that stays within
/// `line_tolerance_m`, but for single ones.
std::vector<ScanLine> extract_lines(std::span<const ScanPoint> run, std::size_t reach_beams, const EkfOptions& options,
                                    Random& random);

}  // namespace rastro
