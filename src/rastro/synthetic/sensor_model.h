// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"

namespace rastro {

/// Effects of a real camera on the incoming light, in their physical order.
struct SensorModel {
  double exposure_time_s = 0.006;  ///< Exposure time, which gives the motion blur. 0: none.
  float gain = 1.0F;               ///< Exposure change: factor on every intensity.
  float vignette = 0.30F;          ///< Share of light lost in the corners.
  float read_noise = 1.2F;         ///< Intensity levels, standard deviation, the same everywhere.
  float shot_noise = 0.02F;        ///< Variance per intensity level.
};

/// Motion of the camera while the shutter is open, as a tangent vector (translation, rotation) in its own frame.
struct ShutterMotion {
  Vector6d motion = Vector6d::Zero();
};

/// Converts an image of light to a camera's intensities. Blur follows each pixel's own flow, from its depth and the
/// camera's motion. `noise_seed` must differ between frames. The same bytes for any pool.
GrayImage expose(const Image<float>& light, const DepthImage& depth, const Camera& camera, const SensorModel& sensor,
                 const ShutterMotion& shutter, std::uint64_t noise_seed, TaskPool& pool);

/// The same for color: four values per pixel (red, green, blue, unused), so that light.width() is four times the
/// image's width. Each channel has its own noise.
ColorImage expose_color(const Image<float>& light, const DepthImage& depth, const Camera& camera,
                        const SensorModel& sensor, const ShutterMotion& shutter, std::uint64_t noise_seed,
                        TaskPool& pool);

}  // namespace rastro
