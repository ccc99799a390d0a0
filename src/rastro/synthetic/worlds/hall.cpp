// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/hall.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/synthetic/worlds/hall_scene.h"

namespace rastro {
namespace {

/// EuRoC's left camera (Burri et al. 2016).
Camera hall_camera(const HallOptions& options) {
  Camera camera;
  camera.width = 752, camera.height = 480;
  camera.fx = 458.654, camera.fy = 457.296, camera.cx = 367.215, camera.cy = 248.375;
  if (options.distortion) {
    camera.distortion = Distortion::radial_tangential;
    camera.coefficients = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0.0};
  }
  return options.scale == 1.0 ? camera : camera.scaled(options.scale);
}

SE3 hall_body_from_camera() {
  Eigen::Matrix4d matrix;
  matrix << 0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,  //
      0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768,            //
      -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949,        //
      0.0, 0.0, 0.0, 1.0;
  return SE3::from_matrix(matrix);
}

/// Exposure drifts slowly; at 3.2 s it jumps, like automatic exposure when a bright window comes into view.
SensorModel hall_sensor(double time_s) {
  SensorModel sensor;
  sensor.gain = static_cast<float>(1.0 + 0.08 * std::sin(2.0 * std::numbers::pi * time_s / 7.3));
  const double since_jump = time_s - 3.2;
  const double jump = 0.5 + 0.5 * std::tanh(since_jump / 0.06);
  sensor.gain *= static_cast<float>(1.0 - 0.22 * jump * std::exp(-std::max(0.0, since_jump) / 1.5));
  return sensor;
}

}  // namespace

World make_hall(const HallOptions& options) {
  if (!(options.scale >= 0.05 && options.scale <= 4.0))
    throw Error("the scale is out of range", "hall", "use 0.05 to 4");
  World::Parts parts{"hall",        hall_camera(options), hall::flight(), hall_sensor,
                     hall::rate_hz, 1403636579763555584,  options.seed,   hall_body_from_camera()};
  return World(hall::build_scene(options.seed, options.threads, std::min(1.0, options.scale)), std::move(parts));
}

}  // namespace rastro
