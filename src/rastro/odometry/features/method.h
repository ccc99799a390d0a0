// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/odometry/odometry_method.h"

namespace rastro {

/// Monocular odometry from features: a local map of points; every pose from the points observed in the frame.
std::unique_ptr<OdometryMethod> features_odometry_method();

}  // namespace rastro
