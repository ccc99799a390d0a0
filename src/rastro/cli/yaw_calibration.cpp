// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/yaw_calibration.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "rastro/registration/profiles/calibrate_yaw.h"

namespace rastro::cli {
namespace {

/// Yaw to the left between two poses of the camera.
double yaw_to_left(const SE3& world_from_before, const SE3& world_from_after) {
  const Eigen::Vector3d ahead =
      world_from_before.rotation().inverse() * (world_from_after.rotation() * Eigen::Vector3d(0.0, 0.0, 1.0));
  return -std::atan2(ahead.x(), ahead.z());
}

}  // namespace

std::string yaw_calibration_report(const Trajectory& trajectory, const Trajectory& reference, double lambda_rad_px) {
  constexpr TimeNs widest = 1'000'000'000;
  std::vector<double> shifts, yaws;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    const auto before = pose_at(reference, trajectory[i - 1].stamp, widest);
    const auto after = pose_at(reference, trajectory[i].stamp, widest);
    if (!before || !after) continue;
    shifts.push_back(yaw_to_left(trajectory[i - 1].world_from_body, trajectory[i].world_from_body) / lambda_rad_px);
    yaws.push_back(yaw_to_left(*before, *after));
  }
  const YawCalibration found = calibrate_yaw(shifts, yaws);
  return fmt::format(
      "lambda = {:.8f} rad/px +- {:.8f}, from {} of {} pairs of frames; rms residual {:.3f} deg\n"
      "this run used {:.8f}; set it with --set lambda={:.8f}\n",
      found.lambda, found.sigma, found.used, shifts.size(), found.rms_rad * 180.0 / std::numbers::pi, lambda_rad_px,
      found.lambda);
}

}  // namespace rastro::cli
