// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/slam/slam_method.h"

namespace rastro {

/// Direct semi-dense SLAM as an entry of the list of methods.
std::unique_ptr<SlamMethod> lsd_slam_method();

}  // namespace rastro
