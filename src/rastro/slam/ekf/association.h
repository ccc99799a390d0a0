// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "rastro/slam/ekf/filter.h"
#include "rastro/slam/ekf/observation.h"
#include "rastro/slam/ekf/options.h"

namespace rastro {

/// The landmark that one observation is associated with.
struct LandmarkAssociation {
  enum class Kind : std::uint8_t {
    landmark,       ///< A landmark of the map: it corrects the filter.
    candidate,      ///< Observed before, but not often enough to be a landmark.
    fresh,          ///< Far from all landmarks: a new candidate.
    ambiguous,      ///< Not used: several matches are possible.
    contradicting,  ///< Not used: near a landmark or with its id, but outside the gate.
    unmatched       ///< Not used, and not compared with the map: the body is lost.
  };
  Kind kind = Kind::fresh;
  std::size_t landmark = 0;
  double distance = 0.0;  ///< Squared Mahalanobis distance to it.
};

/// Associates each observation with the nearest landmark inside the gate, by squared Mahalanobis distance
/// (Durrant-Whyte and Bailey 2006, part II). A candidate is taken only where no landmark is near. Observations with a
/// sensor id are associated by id. Each landmark is taken at most once. Landmarks that the drift makes unsure, see
/// is_unsure(), are not compared with: they are recognized by several together, see recognized_pairs(). `records` are
/// those of the filter's landmarks.
std::vector<LandmarkAssociation> associate(const EkfFilter& filter, std::span<const LandmarkRecord> records,
                                           std::span<const BodyObservation> observations, const EkfOptions& options);

/// The angle between two directions, 0 to pi.
double angle_between(double a, double b);

/// v^T C^-1 v
double squared_mahalanobis(const Eigen::Vector2d& difference, const Eigen::Matrix2d& covariance);

}  // namespace rastro
