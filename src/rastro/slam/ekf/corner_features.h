// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "rastro/slam/ekf/line_extraction.h"

namespace rastro {

/// A distinctive point of a scan, in the laser frame.
struct ScanFeature {
  Eigen::Vector2d position;
  Eigen::Matrix2d covariance;
  double direction = 0.0;  ///< Of a corner: bisector of its two walls, radians.
};

/// Corners: neighboring lines of a run that differ in direction by at least `min_corner_deg` and both end within
/// `corner_gap_m` of their intersection, so that the corner itself was observed and not only computed. `lines` are
/// those of extract_lines(). Points near the corner that one line took from the other are given back first.
std::vector<ScanFeature> find_corners(std::span<const ScanPoint> run, std::vector<ScanLine> lines,
                                      const EkfOptions& options);

/// Poles: runs of a few near beams with a background that is farther by `spike_depth_m` on both sides. The pole's
/// center lies behind its visible surface, by an offset estimated from its width.
std::vector<ScanFeature> find_spikes(const LaserScan& scan, std::span<const std::vector<ScanPoint>> runs,
                                     const EkfOptions& options);

}  // namespace rastro
