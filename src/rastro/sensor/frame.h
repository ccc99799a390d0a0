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

/// One instant of a source: of a camera, a depth camera or a laser scanner. What a source does not have stays empty.
struct Frame {
  std::int64_t index =
      0;  ///< Running number in the source, from 0; of the recording, not of the frames chosen with --frames.
  TimeNs stamp = 0;    ///< Of the (left) image, or of the scan where there is no image.
  std::string name;    ///< File name or frame number, for messages.
  GreyImage image;     ///< Grey, left or only camera.
  GreyImage right;     ///< Grey, right camera of a stereo pair.
  ColourImage colour;  ///< Only where the source was opened with `want_colour`.
  DepthImage depth;    ///< Metres, 0 = none, in the left camera.
  TimeNs depth_stamp = 0;
  GreyImage mask;  ///< Zero where nothing may be used; empty: everything may.
  std::optional<LaserScan> scan;
  std::optional<SE2> odometry_from_body;    ///< Where the wheels say the body is at `stamp`; drifts without bound.
  std::vector<LandmarkSighting> landmarks;  ///< Seen at `stamp`.
  std::vector<ImuSample> imu;               ///< Since the frame before this one.
};

}  // namespace rastro
