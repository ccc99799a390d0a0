// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/odometry/odometry_method.h"

namespace rastro {

/// The positioning paper's classic odometry: three frames at a time, no map and no adjustment.
std::unique_ptr<OdometryMethod> classic_odometry_method();

}  // namespace rastro
