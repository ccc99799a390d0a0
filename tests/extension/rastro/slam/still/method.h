// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/slam/slam_method.h"

namespace rastro {

/// Takes the robot to stand still; its map is one keyframe.
std::unique_ptr<SlamMethod> still_slam_method();

}  // namespace rastro
