// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/observation.h"

#include <cmath>
#include <numbers>

namespace rastro {

std::vector<BodyObservation> given_observations(std::span<const LandmarkMeasurement> landmarks,
                                                const EkfOptions& options) {
  const double bearing_noise = options.bearing_noise_deg * std::numbers::pi / 180.0;
  std::vector<BodyObservation> result;
  for (const LandmarkMeasurement& seen : landmarks) {
    const bool usable = seen.range > 0.0 && seen.range <= options.max_observation_m && std::isfinite(seen.bearing);
    if (!usable) continue;
    BodyObservation observation;
    observation.sensor_id = seen.id;
    const SO2 direction = SO2::from_angle(seen.bearing);
    observation.in_body = direction * Eigen::Vector2d(seen.range, 0.0);
    const double along = options.range_noise_m + options.range_noise_share * seen.range;
    const double across = bearing_noise * seen.range;
    const Eigen::Matrix2d rotation = direction.matrix();
    // A landmark at the sensor itself has no bearing error, but its covariance must not be singular.
    const double least = 1e-3 * options.range_noise_m;
    const Eigen::Vector2d variances(along * along, across * across + least * least);
    observation.covariance = rotation * variances.asDiagonal() * rotation.transpose();
    result.push_back(observation);
  }
  return result;
}

}  // namespace rastro
