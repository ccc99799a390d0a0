// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/math/se2.h"
#include "rastro/synthetic/laser_model.h"
#include "rastro/synthetic/scene.h"

namespace rastro {

/// A landmark that can be recognized: a door post or a column.
struct LaserLandmark {
  std::int64_t id = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< In the world, meters.
  double radius = 0.0;                                 ///< Of the solid around it, meters.
};

/// A generated building with a wheeled robot. The world is the robot's start pose: x ahead, y left, z up, the floor at
/// z = 0.
struct LaserWorld {
  std::string name;
  std::uint64_t seed = 1;
  /// With its bounds tree; only upright boxes and cylinders reach the height of the laser.
  std::shared_ptr<const Scene> scene;
  std::vector<GlassPane> panes;
  std::vector<LaserLandmark> landmarks;
  LaserModel laser;
  std::function<SE2(double time_s)> world_from_body;
  double duration_s = 0.0;
  double rate_hz = 10.0;
  TimeNs first_stamp = 0;

  /// Number of scans from the start to the end of the drive.
  std::int64_t scan_count() const { return 1 + static_cast<std::int64_t>(duration_s * rate_hz); }
  double time_of(std::int64_t scan) const { return static_cast<double>(scan) / rate_hz; }
  TimeNs stamp(std::int64_t scan) const { return first_stamp + from_seconds(time_of(scan)); }
};

}  // namespace rastro
