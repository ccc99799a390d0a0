// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "rastro/slam/ekf/filter.h"
#include "rastro/slam/ekf/options.h"
#include "rastro/slam/ekf/sighting.h"

namespace rastro {

/// What one sighting is taken for.
struct LandmarkAssociation {
  enum class Kind : std::uint8_t {
    landmark,      ///< Of the map: it corrects the filter.
    candidate,     ///< Seen before, but not often enough to be a landmark.
    fresh,         ///< Far from all: a new candidate.
    ambiguous,     ///< Two landmarks would do, or another sighting fits this one better, or it stands alone: not used.
    contradicting  ///< Near a landmark or of its name, but outside the gate: not used.
  };
  Kind kind = Kind::fresh;
  std::size_t landmark = 0;
  double distance = 0.0;  ///< Squared Mahalanobis distance to it.
};

/// Each sighting to the nearest landmark inside the gate, by squared Mahalanobis distance (Durrant-Whyte and Bailey
/// 2006, part II), and to a candidate only where no landmark is near; by name where the sensor gives one. A landmark is
/// taken once at most. Where the body's place is so uncertain that the gate of a landmark is wider than `unsure_m`, it
/// is recognised only together with `companions` others that lie as far from it as the map says. `records` are those of
/// the filter's landmarks.
std::vector<LandmarkAssociation> associate(const EkfFilter& filter, std::span<const LandmarkRecord> records,
                                           std::span<const BodySighting> sightings, const EkfOptions& options);

/// The angle between two directions, 0 to pi.
double angle_between(double a, double b);

/// v^T C^-1 v
double squared_mahalanobis(const Eigen::Vector2d& difference, const Eigen::Matrix2d& covariance);

}  // namespace rastro
