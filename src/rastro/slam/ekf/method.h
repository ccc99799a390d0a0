// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/slam/slam_method.h"

namespace rastro {

/// EKF-SLAM with landmarks: line corners and spikes of 2D scans, or range and bearing.
std::unique_ptr<SlamMethod> ekf_slam_method();

}  // namespace rastro
