// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/point_map.h"

#include <algorithm>

namespace rastro {
namespace {

// Readings of one point share most of their error: more than these add no information.
constexpr double most_readings = 4.0;

}  // namespace

void PointMap::add_reading(MapPoint& point, const DepthReading& reading) {
  const double share = 1.0 / (std::min(point.readings, 20.0) + 1.0);
  point.inverse_depth += share * (reading.inverse_depth - point.inverse_depth);
  point.per_second += share * (reading.per_second - point.per_second);
  point.readings += 1.0;
  point.information = std::min(point.readings, most_readings) / (reading.sigma * reading.sigma);
}

void PointMap::forget(int count, int most_missed) {
  const int oldest = std::max(first_live, static_cast<int>(references.size()) - count);
  for (int i = oldest - 1; i >= 0 && !references[static_cast<std::size_t>(i)].planes.empty(); --i) {
    references[static_cast<std::size_t>(i)].planes = std::vector<BlockPlane>();  // "= {}" would keep the memory
  }
  std::erase_if(points, [&](const MapPoint& point) { return point.anchor < oldest || point.missed > most_missed; });
}

void PointMap::delay_depths(double seconds) {
  for (std::size_t i = static_cast<std::size_t>(first_live); i < references.size(); ++i) {
    if (!references[i].planes.empty())
      references[i].camera_from_depth = references[i].camera_from_depth * SE3::exp(seconds * references[i].velocity);
  }
  for (MapPoint& point : points) {
    const double change = seconds * point.per_second;
    if (point.inverse_depth + change > 0.0) point.inverse_depth += change;
  }
}

}  // namespace rastro
