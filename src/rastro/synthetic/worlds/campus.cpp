// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/campus.h"

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/synthetic/worlds/campus_light.h"
#include "rastro/synthetic/worlds/campus_scene.h"
#include "rastro/synthetic/worlds/campus_walk.h"

namespace rastro {
namespace {

constexpr double baseline_m = 0.12;

Camera campus_camera(double scale) {
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 420.0, camera.cx = 319.5, camera.cy = 239.5;
  return scale == 1.0 ? camera : camera.scaled(scale);
}

/// The body is midway between the cameras, x ahead, y to the left, z up.
SE3 campus_body_from_camera() { return {looking(0.0, 0.0, 0.0), {0.0, 0.5 * baseline_m, 0.0}}; }

}  // namespace

World make_campus(const CampusOptions& options) {
  if (!(options.scale >= 0.05 && options.scale <= 4.0))
    throw Error("the scale is out of range", "campus", "use 0.05 to 4");
  World::Parts parts{"campus",        campus_camera(options.scale), campus::walk_path(), campus::sensor_at,
                     campus::rate_hz, 1672570800000000000,          options.seed,        campus_body_from_camera()};
  parts.left_from_right = SE3(SO3(), {baseline_m, 0.0, 0.0});
  parts.light = campus::make_light(options.seed);
  return World(campus::build_scene(options.seed, options.threads, std::min(1.0, options.scale)), std::move(parts));
}

}  // namespace rastro
