// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rastro/base/options.h"
#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/odometry/features/options.h"
#include "rastro/odometry/hybrid/options.h"
#include "rastro/odometry/odometry.h"
#include "rastro/odometry/profiles/options.h"
#include "rastro/odometry/rgbd/options.h"

namespace rastro {

/// The names of the odometries.
const std::vector<std::string>& odometry_methods();
/// One line on how it works. Error for a name that is no method.
std::string odometry_summary(const std::string& method);
/// Whether the method needs pictures with depth, and then knows lengths in metres.
bool odometry_needs_depth(const std::string& method);

/// The settings of every odometry, defaults at first.
struct OdometrySettings {
  FeaturesOptions features;
  ProfilesOptions profiles;
  HybridOptions hybrid;
  RgbdOptions rgbd;

  /// Of one method; points into these settings, which must outlive it. Error for a name that is no method.
  OptionTable table(const std::string& method);
  std::unique_ptr<Odometry> make(const std::string& method, const Camera& camera, TaskPool* pool) const;
};

}  // namespace rastro
