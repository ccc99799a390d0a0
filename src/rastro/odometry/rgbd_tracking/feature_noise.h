// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "rastro/odometry/rgbd_tracking/pose_solver.h"

namespace rastro {

/// How much larger the squared errors of most features are at this pose than `ray_sigma` explains, or than each one's
/// own where none is given. 1 where no point is in front of the camera.
double variance_ratio(const std::vector<PointMeasurement>& measured, const SE3& world_from_camera,
                      std::optional<double> ray_sigma = std::nullopt);

/// Learns how far features are off in a recording: by blur, a rolling shutter, lens and registration of color and
/// depth. With the weight of perfect features they would drag surfaces, which know better, along.
class FeatureNoise {
 public:
  /// Of each frame: how much larger squared errors are than factor() explains.
  void learn(double variance_ratio);
  /// The standard deviation by the settings is multiplied by this; 1 until some frames tell.
  double factor() const { return factor_; }

 private:
  std::deque<double> last_;  ///< Variances of the last frames over those by the settings.
  double factor_ = 1.0;
};

}  // namespace rastro
