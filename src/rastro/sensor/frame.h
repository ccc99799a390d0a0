// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/image/image.h"
#include "rastro/sensor/laser_scan.h"

namespace rastro {

/// One instant of a source: of a camera, a depth camera or a laser scanner. Data that a source does not have stay
/// empty.
struct Frame {
  /// Running number in the source, from 0; of the recording, not of the frames chosen with --frames.
  std::int64_t index = 0;
  TimeNs stamp = 0;  ///< Of the (left) image, or of the scan where there is no image.
  std::string name;  ///< File name or frame number, for messages.
  GrayImage image;   ///< Gray, left or only camera.
  GrayImage right;   ///< Gray, right camera of a stereo pair.
  ColorImage color;  ///< Only if the source was opened with `want_color`.
  DepthImage depth;  ///< Meters, 0 = none, in the left camera.
  TimeNs depth_stamp = 0;
  GrayImage mask;  ///< Zero: pixel must not be used; empty: all may be used.
  std::optional<LaserScan> scan;
  std::optional<SE2> odometry_from_body;       ///< Pose by wheel odometry at `stamp`; drifts without bound.
  std::vector<LandmarkMeasurement> landmarks;  ///< Observed at `stamp`.
  std::vector<ImuSample> imu;                  ///< Since the previous frame.
};

}  // namespace rastro
