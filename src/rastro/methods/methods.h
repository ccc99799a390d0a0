// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rastro/odometry/odometry_method.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// All odometry and SLAM methods with their default settings, in alphabetical order. Both lists are generated from the
/// rastro_method() lines of the build (rastro_list_methods() in cmake/RastroModule.cmake).
std::vector<std::unique_ptr<OdometryMethod>> odometry_methods();
std::vector<std::unique_ptr<SlamMethod>> slam_methods();

/// slam_methods() and, first, `auto`, which chooses among them.
std::vector<std::unique_ptr<SlamMethod>> selectable_slam_methods();

/// A method by name, `auto` too. Error for an unknown name, with the nearest known one.
std::unique_ptr<OdometryMethod> odometry_method(const std::string& name);
std::unique_ptr<SlamMethod> slam_method(const std::string& name);

}  // namespace rastro
