// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/slam.h"

namespace rastro {

const char* name_of(SlamState state) {
  switch (state) {
    case SlamState::initializing:
      return "initializing";
    case SlamState::tracking:
      return "tracking";
    case SlamState::weak:
      return "weak";
    case SlamState::lost:
      return "lost";
    case SlamState::relocalized:
      return "relocalized";
  }
  return "unknown";
}

const char* name_of(SlamReason reason) {
  switch (reason) {
    case SlamReason::none:
      return "none";
    case SlamReason::first_frame:
      return "first_frame";
    case SlamReason::no_data:
      return "no_data";
    case SlamReason::few_returns:
      return "few_returns";
    case SlamReason::poor_match:
      return "poor_match";
    case SlamReason::degenerate:
      return "degenerate";
    case SlamReason::too_few_points:
      return "too_few_points";
    case SlamReason::few_inliers:
      return "few_inliers";
    case SlamReason::no_odometry:
      return "no_odometry";
    case SlamReason::dark_or_blank:
      return "dark_or_blank";
    case SlamReason::repeated_frame:
      return "repeated_frame";
    case SlamReason::gap:
      return "gap";
    case SlamReason::odometry_jumped:
      return "odometry_jumped";
    case SlamReason::blurred:
      return "blurred";
    case SlamReason::not_found:
      return "not_found";
    case SlamReason::apart:
      return "apart";
    case SlamReason::unconfirmed:
      return "unconfirmed";
    case SlamReason::implausible_motion:
      return "implausible_motion";
    case SlamReason::uncertain_scale:
      return "uncertain_scale";
  }
  return "unknown";
}

const char* name_of(ObservationState state) {
  switch (state) {
    case ObservationState::unmatched:
      return "unmatched";
    case ObservationState::matched:
      return "matched";
    case ObservationState::outlier:
      return "outlier";
    case ObservationState::inlier:
      return "inlier";
    case ObservationState::new_landmark:
      return "new";
  }
  return "unknown";
}

}  // namespace rastro
