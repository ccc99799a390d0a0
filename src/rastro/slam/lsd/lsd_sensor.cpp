// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/lsd_sensor.h"

#include <fmt/format.h>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/sensor/stereo_pair.h"

namespace rastro {
namespace {

/// Both cameras; with `auto` only the left one where they cannot be used as a pair.
LsdSensor pair_or_left(const LsdOptions& options, const SourceInfo& source) {
  LsdSensor sensor = single_camera(*source.cameras.front().camera);
  const auto pair = choose_stereo_pair(source, options.sensor == "stereo");
  if (!pair) return sensor;
  sensor.kind = CameraKind::stereo;
  sensor.camera = pair->camera;
  sensor.baseline = pair->baseline;
  sensor.rectification = pair->rectification;
  return sensor;
}

/// Measured depth does not bend with the rows of a rolling shutter, as depths of the images themselves do: during fast
/// rotations most pixels would contradict each other.
bool is_depth_usable(const SourceInfo& source) {
  if (!source.has_depth || source.cameras.front().camera->readout_s <= 0.0) return source.has_depth;
  log_warning(
      fmt::format("{} was taken with a rolling shutter: lsd uses the color images alone, and the scale is "
                  "arbitrary; --sensor rgbd uses the depth all the same, --method orb compensates the shutter",
                  source.path));
  return false;
}

}  // namespace

MapScale LsdSensor::scale() const {
  if (kind == CameraKind::stereo) return {true, 0.0, "stereo baseline"};
  if (kind == CameraKind::depth) return {true, 0.0, "depth camera"};
  return {false, 0.0, "arbitrary"};
}

SE3 LsdSensor::camera_from_left() const {
  return rectification ? SE3(rectification->left_from_rectified.inverse(), Eigen::Vector3d::Zero()) : SE3();
}

LsdSensor single_camera(const Camera& recorded) {
  LsdSensor sensor;
  sensor.recorded = recorded;
  sensor.camera = recorded.distortion == Distortion::none ? recorded : undistorted_camera(recorded, 0.0);
  return sensor;
}

LsdSensor choose_lsd_sensor(const LsdOptions& options, const SourceInfo& source) {
  if (options.sensor == "rgbd" && !source.has_depth)
    throw Error("has no depth images", source.path, "use --sensor mono");
  if (options.sensor == "stereo" && !source.has_right)
    throw Error("has no right images", source.path, "use --sensor mono");
  const bool any = options.sensor == "auto";
  if (!(options.sensor == "rgbd" || (any && is_depth_usable(source)))) {
    if (options.sensor == "stereo" || (any && source.has_right)) return pair_or_left(options, source);
    return single_camera(*source.cameras.front().camera);
  }
  LsdSensor sensor = single_camera(*source.cameras.front().camera);
  sensor.kind = CameraKind::depth;
  return sensor;
}

}  // namespace rastro
