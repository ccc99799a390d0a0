// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/jump_check.h"

#include <cmath>
#include <utility>

namespace rastro {
namespace {

constexpr double most_sigmas = 4.0;
constexpr double longest_interval_s = 0.5;  ///< After more the prediction says little.

}  // namespace

bool JumpCheck::jumps(TimeNs stamp, const SE3& predicted, const SE3& camera_from_world, const Matrix6d& covariance) {
  const double variance = covariance.topLeftCorner<3, 3>().trace();
  const auto before = std::exchange(last_, Last{stamp, variance});
  if (!before || max_acceleration_ == 0.0) return false;
  const double interval = to_seconds(stamp - before->stamp);
  if (!(interval > 0.0) || interval > longest_interval_s) return false;
  const double distance = (camera_from_world.inverse().translation() - predicted.inverse().translation()).norm();
  // The prediction has the errors of the two poses before.
  const double sigma = std::sqrt(variance + 2.0 * before->variance);
  return distance > max_acceleration_ * interval * interval + most_sigmas * sigma;
}

}  // namespace rastro
