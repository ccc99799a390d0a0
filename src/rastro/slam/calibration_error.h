// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/math/se3.h"

namespace rastro {

/// A covariance of (position m, rotation rad) with the errors of the calibration, which no residual shows: an error of
/// the focal length bends the path, one of the baseline or of the scale of depth stretches it. Both grow with the
/// distance and the rotation from where the run began. `share`: CalibratedCamera::calibration_error.
Matrix6d with_calibration_error(const Matrix6d& covariance, const SE3& start_from_body, double share);

}  // namespace rastro
