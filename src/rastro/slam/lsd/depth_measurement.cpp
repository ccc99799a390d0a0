// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth_measurement.h"

#include <algorithm>
#include <cmath>

#include "rastro/odometry/rgbd_tracking/depth_reading.h"
#include "rastro/slam/lsd/tracking/affine_brightness.h"
#include "rastro/slam/lsd/tracking/alignment_reference.h"

namespace rastro {
namespace {

struct Contrast {
  double mean = 0.0, sigma = 0.0;
};

/// Black pixels are masked, or outside what is rectified.
Contrast contrast_of(GrayView image) {
  double count = 0.0, sum = 0.0, squares = 0.0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const double value = image.at(x, y);
      if (value == 0.0) continue;
      count += 1.0, sum += value, squares += value * value;
    }
  if (count == 0.0) return {};
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean))};
}

/// Intensity in the right image = gain * intensity in the left one + offset: both show nearly the same.
AffineBrightness pair_brightness(const Pyramid& left, const Pyramid& right) {
  constexpr int level = 2;
  const Contrast a = contrast_of(left.level(std::min(level, left.levels() - 1)).view()),
                 b = contrast_of(right.level(std::min(level, right.levels() - 1)).view());
  const double gain = a.sigma > 0.0 ? std::clamp(b.sigma / a.sigma, 0.5, 2.0) : 1.0;
  return {gain, b.mean - gain * a.mean};
}

StaticStereo stereo_of(const LsdFrame& frame, const Pyramid& right, const LsdSensor& sensor, const LsdOptions& options,
                       const EpipolarSearchOptions& search) {
  const AffineBrightness brightness = pair_brightness(frame.pyramid, right);
  StaticStereoOptions stereo;
  stereo.baseline = sensor.baseline;
  stereo.max_disparity_px = options.stereo_max_disparity_px;
  stereo.min_disparity_px = options.stereo_min_disparity_px;
  stereo.search = search;
  return {frame.pyramid, right, sensor.camera, brightness.gain, brightness.offset, stereo};
}

}  // namespace

StereoMeasurement::StereoMeasurement(const LsdFrame& frame, const LsdSensor& sensor, const LsdOptions& options,
                                     const EpipolarSearchOptions& search, TaskPool* pool)
    : right_(alignment_pyramid(frame.right.view(), options.levels, pool)),
      stereo_(stereo_of(frame, right_, sensor, options, search)) {}

DepthCameraMeasurement::DepthCameraMeasurement(const DepthImage& depth, const SE3& depth_from_color,
                                               const LsdSensor& sensor, const LsdOptions& options)
    : depth_(depth), depth_from_color_(depth_from_color), sensor_(sensor) {
  reading_.depth_sigma_m = options.depth_sigma_m;
  reading_.depth_sigma_per_m2 = options.depth_sigma_per_m2;
  reading_.depth_edge_sigmas = options.depth_edge_sigmas;
  reading_.min_depth_m = options.min_depth_m;
  reading_.max_depth_m = options.max_depth_m;
}

void DepthCameraMeasurement::find(const EpipolarQueries& queries, EpipolarMatches& matches) const {
  for (std::size_t i = 0; i < static_cast<std::size_t>(queries.count); ++i) {
    const EpipolarMatch found = find(static_cast<int>(queries.x[i]), static_cast<int>(queries.y[i]));
    matches.result[i] = static_cast<int>(found.result);
    matches.mean[i] = found.mean, matches.variance[i] = found.variance;
  }
}

EpipolarMatch DepthCameraMeasurement::find(int x, int y) const {
  const Camera& camera = sensor_.camera;
  const Eigen::Vector2d ray((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy);
  const auto reading = read_depth(depth_, sensor_.recorded, ray, depth_from_color_, reading_);
  if (!reading) return {EpipolarResult::outside};
  return {EpipolarResult::matched, static_cast<float>(reading->inverse_depth),
          static_cast<float>(reading->sigma * reading->sigma)};
}

}  // namespace rastro
