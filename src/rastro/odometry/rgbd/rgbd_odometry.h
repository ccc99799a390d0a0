// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/odometry/odometry.h"
#include "rastro/odometry/rgbd_tracking/options.h"

namespace rastro {

/// The way of a depth camera, METHODS 8, in metres. Frames without depth are followed by what the frames before them
/// showed.
class RgbdOdometry : public Odometry {
 public:
  /// `pool` may be null and must outlive this.
  RgbdOdometry(const RgbdOptions& options, const Camera& camera, TaskPool* pool);
  ~RgbdOdometry() override;
  OdometryUpdate process(const Frame& frame) override;
  Trajectory trajectory() const override;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
