// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/slam/slam_method.h"

namespace rastro {

/// Keyframe SLAM with one camera, two cameras or a depth camera, with its default settings.
std::unique_ptr<SlamMethod> orb_slam_method();

}  // namespace rastro
