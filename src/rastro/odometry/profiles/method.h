// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/odometry/odometry_method.h"

namespace rastro {

/// Rotation from intensity profiles at constant speed, after Milford and Wyeth 2008.
std::unique_ptr<OdometryMethod> profiles_odometry_method();

}  // namespace rastro
