// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "rastro/base/task_pool.h"
#include "rastro/base/time.h"
#include "rastro/camera/undistort_map.h"
#include "rastro/image/pyramid.h"
#include "rastro/sensor/frame.h"
#include "rastro/sensor/stereo_pair.h"
#include "rastro/slam/lsd/lsd_sensor.h"

namespace rastro {

/// An undistorted frame, or the rectified pair, with what aligns and measures it.
struct LsdFrame {
  std::int64_t index = 0;
  TimeNs stamp = 0;
  GrayImage image;
  Pyramid pyramid;         ///< Of the image; masked pixels are black in it, which an alignment takes for clipped.
  GrayImage mask;          ///< Zero: must not be used; empty: all may be.
  GrayImage right;         ///< Of a pair, else empty.
  DepthImage depth;        ///< Of a depth camera, as recorded; else empty.
  TimeNs depth_stamp = 0;  ///< Of the depth.
};

/// Of an alignment's target: what the mask leaves out (empty: nothing) is black.
Pyramid target_pyramid(const GrayImage& image, const GrayImage& mask, int levels, TaskPool* pool);

/// Undistorts or rectifies the frames of a recording.
class LsdFrameMaker {
 public:
  /// `pool` may be null and must outlive this.
  LsdFrameMaker(const LsdSensor& sensor, int levels, TaskPool* pool);
  LsdFrame make(const Frame& recorded) const;
  /// Of an undistorted image.
  LsdFrame from_image(std::int64_t index, TimeNs stamp, GrayImage image, GrayImage mask = {}) const;

 private:
  LsdSensor sensor_;
  int levels_;
  TaskPool* pool_;
  std::optional<UndistortMap> undistort_;
  std::optional<FrameRectifier> rectifier_;
};

}  // namespace rastro
