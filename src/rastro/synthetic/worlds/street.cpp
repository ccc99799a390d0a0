// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/street.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/synthetic/worlds/street_drive.h"
#include "rastro/synthetic/worlds/street_scene.h"

namespace rastro {
namespace {

/// KITTI's left gray camera after rectification (Geiger et al. 2013, recordings of 2011-09-26).
Camera street_camera(double scale) {
  Camera camera;
  camera.width = 1242, camera.height = 375;
  camera.fx = camera.fy = 721.5377, camera.cx = 609.5593, camera.cy = 172.854;
  return scale == 1.0 ? camera : camera.scaled(scale);
}

/// The camera is 1.1 m ahead of the GPS/IMU unit and 0.8 m above it, with a camera's axes, not quite aligned.
SE3 street_body_from_camera() {
  return {SO3::exp({0.004, -0.007, 0.005}) * looking(0.0, 0.0, 0.0), {1.08, -0.31, 0.72}};
}

/// The exposure follows the scene slowly; at 9 s and 27 s the sun comes out and goes, and the camera reacts with a
/// delay.
SensorModel street_sensor(double time_s) {
  SensorModel sensor;
  sensor.exposure_time_s = 0.002;
  sensor.vignette = 0.12F;
  const double sun = 0.5 * (std::tanh((time_s - 9.0) / 0.15) - std::tanh((time_s - 27.0) / 0.15));
  const double answer = 0.5 * (std::tanh((time_s - 9.9) / 0.4) - std::tanh((time_s - 27.9) / 0.4));
  const double drift = 0.06 * std::sin(2.0 * std::numbers::pi * time_s / 8.7);
  sensor.gain = static_cast<float>(0.95 + drift + 0.30 * sun - 0.22 * answer);
  return sensor;
}

}  // namespace

World make_street(const StreetOptions& options) {
  if (!(options.scale >= 0.05 && options.scale <= 4.0))
    throw Error("the scale is out of range", "street", "use 0.05 to 4");
  World::Parts parts{"street",        street_camera(options.scale), street::drive_path(), street_sensor,
                     street::rate_hz, 1577880000000000000,          options.seed,         street_body_from_camera()};
  return World(street::build_scene(options.seed, options.threads, std::min(1.0, options.scale)), std::move(parts));
}

}  // namespace rastro
