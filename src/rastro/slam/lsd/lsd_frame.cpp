// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/lsd_frame.h"

#include <algorithm>
#include <utility>

#include "rastro/slam/lsd/tracking/alignment_reference.h"

namespace rastro {
namespace {

GrayImage with_black(const GrayImage& image, const GrayImage& mask) {
  GrayImage result = image;
  for (int y = 0; y < image.height(); ++y)
    std::transform(mask.row(y), mask.row(y) + mask.width(), image.row(y), result.row(y),
                   [](std::uint8_t usable, std::uint8_t value) { return usable == 0 ? std::uint8_t{0} : value; });
  return result;
}

/// A border between black and white is interpolated: only what is white altogether may be used.
GrayImage undistorted_mask(const GrayImage& mask, const UndistortMap& map, TaskPool* pool) {
  GrayImage white(mask.width(), mask.height());
  for (int y = 0; y < mask.height(); ++y)
    std::transform(mask.row(y), mask.row(y) + mask.width(), white.row(y),
                   [](std::uint8_t value) { return value == 0 ? std::uint8_t{0} : std::uint8_t{255}; });
  GrayImage result = remap(white.view(), map, pool);
  for (int y = 0; y < result.height(); ++y)
    std::transform(result.row(y), result.row(y) + result.width(), result.row(y),
                   [](std::uint8_t value) { return value == 255 ? value : std::uint8_t{0}; });
  return result;
}

}  // namespace

Pyramid target_pyramid(const GrayImage& image, const GrayImage& mask, int levels, TaskPool* pool) {
  if (mask.empty()) return alignment_pyramid(image.view(), levels, pool);
  return alignment_pyramid(with_black(image, mask).view(), levels, pool);
}

LsdFrameMaker::LsdFrameMaker(const LsdSensor& sensor, int levels, TaskPool* pool)
    : sensor_(sensor), levels_(levels), pool_(pool) {
  if (sensor.rectification)
    rectifier_.emplace(sensor.rectification, pool);
  else if (sensor.recorded.distortion != Distortion::none)
    undistort_ = undistort_map(sensor.recorded, sensor.camera);
}

LsdFrame LsdFrameMaker::from_image(std::int64_t index, TimeNs stamp, GrayImage image, GrayImage mask) const {
  LsdFrame frame;
  frame.index = index;
  frame.stamp = stamp;
  frame.image = std::move(image);
  frame.mask = std::move(mask);
  frame.pyramid = target_pyramid(frame.image, frame.mask, levels_, pool_);
  return frame;
}

LsdFrame LsdFrameMaker::make(const Frame& recorded) const {
  if (rectifier_) {
    Frame rectified = rectifier_->rectified(recorded);
    LsdFrame frame = from_image(recorded.index, recorded.stamp, std::move(rectified.image), std::move(rectified.mask));
    frame.right = std::move(rectified.right);
    return frame;
  }
  const bool masked = !recorded.mask.empty();
  LsdFrame frame = undistort_
                       ? from_image(recorded.index, recorded.stamp, remap(recorded.image.view(), *undistort_, pool_),
                                    masked ? undistorted_mask(recorded.mask, *undistort_, pool_) : GrayImage())
                       : from_image(recorded.index, recorded.stamp, recorded.image, recorded.mask);
  if (sensor_.kind == CameraKind::stereo) frame.right = recorded.right;
  if (sensor_.kind == CameraKind::depth) {
    frame.depth = recorded.depth;
    frame.depth_stamp = recorded.depth_stamp;
  }
  return frame;
}

}  // namespace rastro
