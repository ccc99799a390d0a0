// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>

#include "rastro/math/se3.h"

namespace rastro {

/// How uncertain the parts of a map (keyframes, submaps) are relative to the first, for the covariances of poses
/// tracked against them. Each part has the errors of the one that it was tracked against, and its own: an upper bound,
/// as optimization only reduces them. Where tracking comes back to an early part, its smaller uncertainty counts again.
///
/// Covariances are of (position m, rotation rad) in the world's axes.
class MapUncertainty {
 public:
  /// Of a pose at `position` tracked against a part, from its covariance relative to the map around. A part that was
  /// never added is certain.
  Matrix6d of_pose(std::int64_t part, const Eigen::Vector3d& position, const Matrix6d& tracked) const;
  /// Replaces what was known of the part.
  void set(std::int64_t part, const Eigen::Vector3d& position, const Matrix6d& covariance);
  /// As set(), where it is less uncertain than before, as after a loop closure.
  void reduce(std::int64_t part, const Eigen::Vector3d& position, const Matrix6d& covariance);

 private:
  struct Entry {
    Eigen::Vector3d position;
    Matrix6d covariance;
  };
  std::map<std::int64_t, Entry> parts_;
};

}  // namespace rastro
