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
  given,   ///< By a sensor that finds landmarks itself, with or without names.
  corner,  ///< Where two lines of a scan meet.
  spike,   ///< A pole: a few near beams in front of a far background.
};

/// One landmark as seen from the body at one instant.
struct BodySighting {
  LandmarkKind kind = LandmarkKind::given;
  std::int64_t sensor_id = -1;                               ///< As the sensor names it, else -1.
  Eigen::Vector2d in_body = Eigen::Vector2d::Zero();         ///< Metres.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  ///< Of in_body, m^2; positive definite.
  /// Of a corner: where its two walls lead on average, radians in the body frame. A corner of a room and one of a
  /// pillar at the same place look opposite ways.
  double direction = 0.0;
};

/// A landmark of the filter, which keeps its place under the same number.
struct LandmarkRecord {
  /// The map's own, in the order in which candidates became landmarks; -1: still a candidate. It stands in the filter
  /// with all its covariances from the first sighting on, but corrects nothing.
  std::int64_t id = -1;
  LandmarkKind kind = LandmarkKind::given;
  std::int64_t sensor_id = -1;
  double direction = 0.0;  ///< As in BodySighting, in the world.
  int observations = 0;
  std::int64_t last_frame = 0;  ///< In which it was last seen.

  bool is_candidate() const { return id < 0; }
};

/// Range and bearing as places in the body frame, with the noise of the options. What is not a number, not in front of
/// the sensor or farther than `max_sighting_m` is left out.
std::vector<BodySighting> given_sightings(std::span<const LandmarkSighting> landmarks, const EkfOptions& options);

}  // namespace rastro
