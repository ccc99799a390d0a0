// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/scan_features.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/slam/ekf/corner_features.h"
#include "rastro/slam/ekf/line_extraction.h"

namespace rastro {
namespace {

BodyObservation observation_of(const ScanFeature& feature, LandmarkKind kind, const SE2& body_from_laser) {
  const Eigen::Matrix2d rotation = body_from_laser.rotation().matrix();
  return {kind, -1, body_from_laser * feature.position, rotation * feature.covariance * rotation.transpose(),
          feature.direction + body_from_laser.rotation().angle()};
}

std::size_t reach_in_beams(const LaserScan& scan, const EkfOptions& options) {
  const double step = std::max(std::abs(scan.angle_step), 1e-6);
  return static_cast<std::size_t>(options.ransac_reach_deg * std::numbers::pi / 180.0 / step);
}

}  // namespace

std::vector<BodyObservation> scan_observations(const LaserScan& scan, const EkfOptions& options, Random& random) {
  std::vector<BodyObservation> observations;
  const auto runs = runs_of(scan, options);
  if (options.corners) {
    for (const auto& run : runs) {
      for (const ScanFeature& corner :
           find_corners(run, extract_lines(run, reach_in_beams(scan, options), options, random), options)) {
        observations.push_back(observation_of(corner, LandmarkKind::corner, scan.body_from_laser));
      }
    }
  }
  if (options.spikes) {
    for (const ScanFeature& spike : find_spikes(scan, runs, options)) {
      observations.push_back(observation_of(spike, LandmarkKind::spike, scan.body_from_laser));
    }
  }
  // In a broken scan all beams may coincide; no line follows from that.
  std::erase_if(observations, [](const BodyObservation& observation) {
    return !observation.in_body.allFinite() || !observation.covariance.allFinite() ||
           !std::isfinite(observation.direction);
  });
  return observations;
}

std::vector<Eigen::Vector2d> returns_in(const LaserScan& scan, const SE2& frame_from_laser) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(scan.ranges.size());
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (!scan.is_return(beam)) continue;
    const double angle = scan.angle_of(beam), range = static_cast<double>(scan.ranges[beam]);
    points.push_back(frame_from_laser * Eigen::Vector2d(range * std::cos(angle), range * std::sin(angle)));
  }
  return points;
}

}  // namespace rastro
