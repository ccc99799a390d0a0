// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/odometry/odometry_method.h"

namespace rastro {

/// Rotation from intensity profiles, translation from two points at a time.
std::unique_ptr<OdometryMethod> hybrid_odometry_method();

}  // namespace rastro
