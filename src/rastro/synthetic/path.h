// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>

#include "rastro/math/se3.h"

namespace rastro {

/// An endless camera trajectory. From control poses it is a uniform cubic B-spline, cumulative in the rotation (Kim,
/// Kim and Shin 1995), so that position and rotation have continuous second derivatives; control poses are computed
/// when needed.
class CameraPath {
 public:
  /// world_from_camera of control pose `index`; the trajectory passes near it at time index * spacing_s. Must depend on
  /// `index` alone.
  using Controls = std::function<SE3(std::int64_t index)>;

  CameraPath(Controls controls, double spacing_s) : controls_(std::move(controls)), spacing_s_(spacing_s) {}
  /// A trajectory known at all times. Must depend on the time alone.
  explicit CameraPath(std::function<SE3(double time_s)> exact) : exact_(std::move(exact)) {}
  SE3 world_from_camera(double time_s) const;

 private:
  Controls controls_;
  double spacing_s_ = 0.0;
  std::function<SE3(double time_s)> exact_;
};

/// Rotation of a camera that looks along the world's x axis (z up), rotated by yaw to the left, pitch downwards and
/// roll about its own axis, radians.
SO3 looking(double yaw, double pitch, double roll);

}  // namespace rastro
