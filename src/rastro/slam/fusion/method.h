// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/slam/slam_method.h"

namespace rastro {

std::unique_ptr<SlamMethod> fusion_slam_method();

}  // namespace rastro
