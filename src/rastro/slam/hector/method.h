// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/slam/slam_method.h"

namespace rastro {

/// 2D scan matching with loop closing, after Kohlbrecher et al. 2011.
std::unique_ptr<SlamMethod> hector_slam_method();

}  // namespace rastro
