// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/calibration_error.h"

namespace rastro {

Matrix6d with_calibration_error(const Matrix6d& covariance, const SE3& start_from_body, double share) {
  const double position = share * start_from_body.translation().norm();
  const double rotation = share * start_from_body.rotation().log().norm();
  Matrix6d sum = covariance;
  sum.diagonal().head<3>().array() += position * position;
  sum.diagonal().tail<3>().array() += rotation * rotation;
  return sum;
}

}  // namespace rastro
