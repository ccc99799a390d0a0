// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/slam/slam_method.h"

namespace rastro {

/// Appearance-based SLAM with memory management, after Labbe and Michaud 2013 and 2014.
std::unique_ptr<SlamMethod> rtabmap_slam_method();

}  // namespace rastro
