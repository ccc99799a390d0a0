// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "rastro/slam/ekf/line_extraction.h"

namespace rastro {

/// A point of a scan that can be told again from elsewhere, in the laser frame.
struct ScanFeature {
  Eigen::Vector2d place;
  Eigen::Matrix2d covariance;
  double direction = 0.0;  ///< Of a corner: between its two walls, radians.
};

/// Where neighbouring lines of a run meet: they turn by `min_corner_deg` at least and both end within `corner_gap_m` of
/// the crossing, so that the corner was seen and not only computed. `lines` are those of extract_lines(); points that
/// one line took from the other near the corner are given back first.
std::vector<ScanFeature> find_corners(std::span<const ScanPoint> run, std::vector<ScanLine> lines,
                                      const EkfOptions& options);

/// Poles: runs of few near beams, with a background that is farther by `spike_depth_m` on both sides. The pole's middle
/// lies behind what is seen of it, by what its width says.
std::vector<ScanFeature> find_spikes(const LaserScan& scan, std::span<const std::vector<ScanPoint>> runs,
                                     const EkfOptions& options);

}  // namespace rastro
