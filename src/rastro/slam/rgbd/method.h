// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/slam/slam_method.h"

namespace rastro {

/// RGB-D SLAM with a graph of keyframes, after Endres et al. 2014.
std::unique_ptr<SlamMethod> rgbd_slam_method();

}  // namespace rastro
