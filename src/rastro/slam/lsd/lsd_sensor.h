// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/camera/stereo_rectification.h"
#include "rastro/map/graph/map.h"
#include "rastro/sensor/source.h"
#include "rastro/slam/lsd/options.h"

namespace rastro {

/// What a run uses of the recording's sensors.
struct LsdSensor {
  CameraKind kind = CameraKind::mono;
  Camera recorded;        ///< Of the (left) images as recorded; a depth camera's depth is registered to it.
  Camera camera;          ///< Of the undistorted or rectified images: a pinhole without distortion.
  double baseline = 0.0;  ///< Of a pair, meters.
  /// For a pair that is not rectified; null: images are only undistorted.
  std::shared_ptr<const StereoRectification> rectification;

  /// Depth in meters is measured: the scale is fixed.
  bool is_metric() const { return kind != CameraKind::mono; }
  MapScale scale() const;
  DepthNoise depth_noise(const LsdOptions& options) const {
    return {options.depth_sigma_m, options.depth_sigma_per_m2};
  }
  SE3 camera_from_left() const;  ///< From the recording's (left) camera frame; identity where not rectified.
  SE3 right_from_left() const { return {SO3(), {-baseline, 0.0, 0.0}}; }  ///< Of the rectified pair.
};

/// One camera without depth.
LsdSensor single_camera(const Camera& recorded);
/// All sensors of the source, or the one named in `sensor`; Error where the source lacks it.
LsdSensor choose_lsd_sensor(const LsdOptions& options, const SourceInfo& source);

}  // namespace rastro
