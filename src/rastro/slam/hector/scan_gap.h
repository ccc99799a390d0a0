// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "rastro/slam/hector/scan_follower.h"

namespace rastro {

/// A time without scans that tell a pose, up to a scan whose surroundings are mostly new.
struct ScanGap {
  double seconds = 0.0;
  /// Of the pose after it, (x, y, angle), local axes: what the map before it does not tell of the pose.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// `seconds`: as MotionGuess::gap_s(), 0 without a gap. nullopt where there was none, where the scan fits nowhere, and
/// where most of it was mapped before, so that the match tells the pose.
std::optional<ScanGap> gap_before(double seconds, const ScanGuess& guess, const FollowedScan& followed);

}  // namespace rastro
