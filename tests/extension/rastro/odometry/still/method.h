// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/odometry/odometry_method.h"

namespace rastro {

/// Takes the camera to stand still.
std::unique_ptr<OdometryMethod> still_odometry_method();

}  // namespace rastro
