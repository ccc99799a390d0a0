// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/scan_features.h"

namespace rastro {

std::vector<Sighting> scan_sightings(const LaserScan&, const EkfOptions&, Random&) { return {}; }

std::vector<Eigen::Vector2d> returns_in(const LaserScan& scan, const SE2& frame_from_laser) {
  std::vector<Eigen::Vector2d> points;
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (!scan.is_return(beam)) continue;
    const double angle = scan.angle_of(beam), range = static_cast<double>(scan.ranges[beam]);
    points.push_back(frame_from_laser * Eigen::Vector2d(range * std::cos(angle), range * std::sin(angle)));
  }
  return points;
}

}  // namespace rastro
