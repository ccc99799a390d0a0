// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/cli/live_sink.h"
#include "rastro/odometry/odometry.h"
#include "rastro/session/odometry_run.h"
#include "rastro/viewer/feature_trails.h"

namespace rastro::cli {

/// --view of `rastro odometry`: each image with its features and their trails, and the trajectory so far.
class LiveOdometry {
 public:
  LiveOdometry(const ServerFlags& flags, const LiveHello& run, const Odometry& method);

  /// After a frame. Waits while the page has paused the run.
  void show(const Frame& frame, const OdometryUpdate& update);
  /// The result of the run and its final trajectory, after it.
  void finish(const OdometryRunEnd& end);
  void wait_until_closed() { sink_.wait_until_closed(); }
  /// While a live source gives no frame.
  void idle(const std::string& line) { sink_.idle(line); }

 private:
  void show_image(const Frame& frame);

  const Odometry& method_;
  ViewScene scene_;
  std::int64_t done_ = 0;
  FeatureTrails trails_;
  LiveSink sink_;
};

}  // namespace rastro::cli
