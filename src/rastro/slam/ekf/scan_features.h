// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/base/random.h"
#include "rastro/sensor/laser_scan.h"
#include "rastro/slam/ekf/options.h"
#include "rastro/slam/ekf/sighting.h"

namespace rastro {

/// Corners and spikes of a scan as sightings in the body frame, each with the covariance that the beams' noise gives
/// it.
std::vector<BodySighting> scan_sightings(const LaserScan& scan, const EkfOptions& options, Random& random);

/// Where the beams ended, in the frame to which `frame_from_laser` leads.
std::vector<Eigen::Vector2d> returns_in(const LaserScan& scan, const SE2& frame_from_laser);

}  // namespace rastro
