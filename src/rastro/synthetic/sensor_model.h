// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"

namespace rastro {

/// What a real camera does to the light that reaches it, in the order in which it happens.
struct SensorModel {
  double exposure_time_s = 0.006;  ///< How long the shutter is open: length of the motion blur. 0 = none.
  float gain = 1.0F;               ///< Exposure change: factor on every grey level.
  float vignette = 0.30F;          ///< Share of light lost in the corners.
  float read_noise = 1.2F;         ///< Grey levels, standard deviation, the same everywhere.
  float shot_noise = 0.02F;        ///< Variance per grey level.
};

/// Motion of the camera while the shutter is open, as a tangent vector (translation, rotation) in its own frame.
struct ShutterMotion {
  Vector6d motion = Vector6d::Zero();
};

/// Turns a picture of light into a camera's grey levels. Blur follows each pixel's own flow, from its depth and the
/// camera's motion. `noise_seed` must differ between frames. The same bytes for any pool.
GreyImage expose(const Image<float>& light, const DepthImage& depth, const Camera& camera, const SensorModel& sensor,
                 const ShutterMotion& shutter, std::uint64_t noise_seed, TaskPool& pool);

/// The same for colours: four values a pixel (red, green, blue, unused), so that light.width() is four times the
/// picture's. Each channel has noise of its own.
ColourImage expose_colour(const Image<float>& light, const DepthImage& depth, const Camera& camera,
                          const SensorModel& sensor, const ShutterMotion& shutter, std::uint64_t noise_seed,
                          TaskPool& pool);

}  // namespace rastro
