// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/odometry/rgbd_tracking/options.h"
#include "rastro/slam/lsd/depth/static_stereo.h"
#include "rastro/slam/lsd/lsd_frame.h"
#include "rastro/slam/lsd/options.h"

namespace rastro {

/// Depths that the pair measures at one frame.
class StereoMeasurement {
 public:
  /// A frame with a right image. `frame` outlives this.
  StereoMeasurement(const LsdFrame& frame, const LsdSensor& sensor, const LsdOptions& options,
                    const EpipolarSearchOptions& search, TaskPool* pool);
  void find(const EpipolarQueries& queries, EpipolarMatches& matches) const { stereo_.find(queries, matches); }

 private:
  Pyramid right_;
  StaticStereo stereo_;
};

/// Depths that a depth camera measures at one frame, with its noise; none at the edges of objects.
class DepthCameraMeasurement {
 public:
  /// `depth_from_color`: motion of the camera from the instant of the image to that of its depth. Frame and sensor
  /// outlive this.
  DepthCameraMeasurement(const DepthImage& depth, const SE3& depth_from_color, const LsdSensor& sensor,
                         const LsdOptions& options);
  void find(const EpipolarQueries& queries, EpipolarMatches& matches) const;
  EpipolarMatch find(int x, int y) const;

 private:
  const DepthImage& depth_;
  SE3 depth_from_color_;
  const LsdSensor& sensor_;
  RgbdOptions reading_;
};

}  // namespace rastro
