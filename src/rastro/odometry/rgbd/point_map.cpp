// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd/point_map.h"

#include <algorithm>

namespace rastro {
namespace {

// Readings of one spot share most of their error: more than these tell nothing new.
constexpr double most_readings = 4.0;

}  // namespace

void PointMap::add_reading(MapPoint& point, const DepthReading& reading) {
  const double share = 1.0 / (std::min(point.readings, 20.0) + 1.0);
  point.read_inverse_depth += share * (reading.inverse_depth - point.read_inverse_depth);
  point.readings += 1.0;
  point.information = std::min(point.readings, most_readings) / (reading.sigma * reading.sigma);
}

void PointMap::forget(int count, int most_missed) {
  const int oldest = std::max(first_live, static_cast<int>(references.size()) - count);
  std::erase_if(points, [&](const MapPoint& point) { return point.anchor < oldest || point.missed > most_missed; });
}

}  // namespace rastro
