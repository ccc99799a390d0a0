// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rastro/slam/slam_method.h"

namespace rastro {

/// Every SLAM method with its default settings, in the order of the alphabet. The list is generated from the
/// rastro_method() lines of the build.
std::vector<std::unique_ptr<SlamMethod>> slam_methods();

/// One of them. Error for a name that is no method, naming the nearest.
std::unique_ptr<SlamMethod> slam_method(const std::string& name);

}  // namespace rastro
