// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/odometry/odometry_method.h"

namespace rastro {

/// Odometry of a depth camera against a local map of its last reference frames, in meters.
std::unique_ptr<OdometryMethod> rgbd_odometry_method();

}  // namespace rastro
