// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "rastro/sensor/laser_scan.h"
#include "rastro/slam/ekf/options.h"

namespace rastro {

enum class LandmarkKind : std::uint8_t {
  given,   ///< By a sensor that detects landmarks itself, with or without ids.
  corner,  ///< Where two lines of a scan meet.
  spike,   ///< A pole: a few near beams in front of a far background.
};

/// One landmark as observed from the body at one instant.
struct BodyObservation {
  LandmarkKind kind = LandmarkKind::given;
  std::int64_t sensor_id = -1;                               ///< The sensor's id of the landmark, else -1.
  Eigen::Vector2d in_body = Eigen::Vector2d::Zero();         ///< Meters.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  ///< Of in_body, m^2; positive definite.
  /// Of a corner: bisector of its two walls, radians in the body frame. A concave and a convex corner at the same
  /// position have opposite directions.
  double direction = 0.0;
};

/// A landmark of the filter, under the filter's number.
struct LandmarkRecord {
  /// The map's id, in the order in which candidates became landmarks; -1: still a candidate. A candidate is in the
  /// filter's state with all its covariances from its first observation on, but corrects nothing.
  std::int64_t id = -1;
  LandmarkKind kind = LandmarkKind::given;
  std::int64_t sensor_id = -1;
  double direction = 0.0;  ///< As in BodyObservation, in the world.
  int observations = 0;
  std::int64_t last_frame = 0;  ///< Frame of the last observation.
  /// Trace of the least covariance of the observations that corrected it; of a candidate, of the first.
  double noise_m2 = 0.0;

  bool is_candidate() const { return id < 0; }
};

/// Converts range and bearing to positions in the body frame, with the noise of the options. Skips values that are not
/// finite, not in front of the sensor or farther than `max_observation_m`.
std::vector<BodyObservation> given_observations(std::span<const LandmarkMeasurement> landmarks,
                                                const EkfOptions& options);

}  // namespace rastro
