// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/odometry.h"

namespace rastro {

const char* name_of(OdometryState state) {
  switch (state) {
    case OdometryState::initializing:
      return "initializing";
    case OdometryState::tracking:
      return "tracking";
    case OdometryState::weak:
      return "weak";
    case OdometryState::lost:
      return "lost";
  }
  return "unknown";
}

const char* name_of(OdometryReason reason) {
  switch (reason) {
    case OdometryReason::none:
      return "none";
    case OdometryReason::first_frame:
      return "first_frame";
    case OdometryReason::too_little_parallax:
      return "too_little_parallax";
    case OdometryReason::no_motion:
      return "no_motion";
    case OdometryReason::pure_rotation:
      return "pure_rotation";
    case OdometryReason::too_few_points:
      return "too_few_points";
    case OdometryReason::few_inliers:
      return "few_inliers";
    case OdometryReason::dark_or_blank:
      return "dark_or_blank";
    case OdometryReason::blurred:
      return "blurred";
    case OdometryReason::repeated_frame:
      return "repeated_frame";
    case OdometryReason::gap:
      return "gap";
    case OdometryReason::calibration_doubtful:
      return "calibration_doubtful";
  }
  return "unknown";
}

}  // namespace rastro
