// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/loop.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/synthetic/worlds/loop_scene.h"
#include "rastro/synthetic/worlds/loop_walk.h"

namespace rastro {
namespace {

constexpr double baseline_m = 0.12;

Camera loop_camera(double scale) {
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 420.0, camera.cx = 319.5, camera.cy = 239.5;
  return scale == 1.0 ? camera : camera.scaled(scale);
}

/// The body is midway between the cameras, x ahead, y to the left, z up.
SE3 loop_body_from_camera() { return {looking(0.0, 0.0, 0.0), {0.0, 0.5 * baseline_m, 0.0}}; }

/// The exposure drifts.
SensorModel loop_sensor(double time_s) {
  SensorModel sensor;
  sensor.exposure_time_s = 0.004;
  sensor.vignette = 0.15F;
  sensor.gain = static_cast<float>(1.15 + 0.06 * std::sin(2.0 * std::numbers::pi * time_s / 11.0));
  return sensor;
}

}  // namespace

World make_loop(const LoopOptions& options) {
  if (!(options.scale >= 0.05 && options.scale <= 4.0))
    throw Error("the scale is out of range", "loop", "use 0.05 to 4");
  World::Parts parts{"loop",        loop_camera(options.scale), loop::walk_path(), loop_sensor,
                     loop::rate_hz, 1609459200000000000,        options.seed,      loop_body_from_camera()};
  parts.left_from_right = SE3(SO3(), {baseline_m, 0.0, 0.0});
  return World(loop::build_scene(options.seed, options.threads, std::min(1.0, options.scale)), std::move(parts));
}

}  // namespace rastro
