// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/odometry/features/options.h"
#include "rastro/odometry/odometry.h"

namespace rastro {

/// Monocular odometry from features, METHODS 2.1. The essential matrix of the first pair of frames with enough parallax
/// gives the first map points; every further pose comes from P3P on observed map points; the last keyframes are
/// bundle-adjusted. Lengths are up to scale: the baseline of the first pair of keyframes has length 1.
class FeaturesOdometry : public Odometry {
 public:
  /// Throws Error for settings out of range. The pool must outlive the odometry; results do not depend on it.
  FeaturesOdometry(const FeaturesOptions& options, const Camera& camera, TaskPool* pool = nullptr);
  ~FeaturesOdometry() override;

  OdometryUpdate process(const Frame& frame) override;
  Trajectory trajectory() const override;
  std::vector<OdometryFeature> features() const override;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
