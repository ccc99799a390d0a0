// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/odometry/odometry.h"
#include "rastro/odometry/rgbd_tracking/options.h"

namespace rastro {

/// Odometry of a depth camera, METHODS 8, in meters. Frames without depth are tracked against the local map of earlier
/// frames.
class RgbdOdometry : public Odometry {
 public:
  /// `pool` may be null and must outlive this.
  RgbdOdometry(const RgbdOptions& options, const Camera& camera, TaskPool* pool);
  ~RgbdOdometry() override;
  OdometryUpdate process(const Frame& frame) override;
  Trajectory trajectory() const override;
  std::vector<OdometryFeature> features() const override;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
