// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/base/random.h"
#include "rastro/sensor/laser_scan.h"
#include "rastro/slam/ekf/observation.h"
#include "rastro/slam/ekf/options.h"

namespace rastro {

/// Corners and spikes of a scan as observations in the body frame, each with the covariance that follows from the
/// beams' noise.
std::vector<BodyObservation> scan_observations(const LaserScan& scan, const EkfOptions& options, Random& random);

/// End points of the beams, in the target frame of `frame_from_laser`.
std::vector<Eigen::Vector2d> returns_in(const LaserScan& scan, const SE2& frame_from_laser);

}  // namespace rastro
