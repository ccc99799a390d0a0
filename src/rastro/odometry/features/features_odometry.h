// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/odometry/features/options.h"
#include "rastro/odometry/odometry.h"

namespace rastro {

/// Monocular odometry from features, METHODS 2.1: essential matrix of the first pair of frames with enough parallax,
/// points in space, every further pose from the points it sees (P3P), and bundle adjustment of the last keyframes.
/// Lengths are relative: the first pair of keyframes is one unit apart.
class FeaturesOdometry : public Odometry {
 public:
  /// Throws Error for settings out of range. The pool must outlive the odometry; results do not depend on it.
  FeaturesOdometry(const FeaturesOptions& options, const Camera& camera, TaskPool* pool = nullptr);
  ~FeaturesOdometry() override;

  OdometryUpdate process(const Frame& frame) override;
  Trajectory trajectory() const override;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
