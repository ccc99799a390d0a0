// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/corridor.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "rastro/base/error.h"
#include "rastro/synthetic/worlds/corridor_drive.h"
#include "rastro/synthetic/worlds/corridor_scene.h"

namespace rastro {
namespace {

constexpr double rate_hz = 10.0;
constexpr TimeNs first_stamp = 1577880000000000000;

Camera corridor_camera(double scale) {
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 525.0, camera.cx = 319.5, camera.cy = 239.5;
  return scale == 1.0 ? camera : camera.scaled(scale);
}

SE3 corridor_body_from_camera() { return {looking(0.0, 0.0, 0.0), {0.15, 0.0, 0.80}}; }

SensorModel corridor_sensor(double) {
  SensorModel sensor;
  sensor.exposure_time_s = 0.004;
  sensor.vignette = 0.15F;
  return sensor;
}

CameraPath corridor_path() {
  const auto drive = std::make_shared<const corridor::Drive>();
  return CameraPath([drive](double time_s) {
    const SE2 plan = drive->world_from_body(time_s);
    const SE3 world_from_body(SO3::exp({0, 0, plan.rotation().angle()}),
                              {plan.translation().x(), plan.translation().y(), 0.0});
    return world_from_body * corridor_body_from_camera();
  });
}

}  // namespace

LaserWorld make_corridor_floor(const CorridorOptions& options) {
  corridor::Floor floor = corridor::build_floor(options.seed);
  floor.scene->make_tree();
  const auto drive = std::make_shared<const corridor::Drive>();
  LaserWorld world;
  world.name = "corridor";
  world.seed = options.seed;
  world.scene = std::move(floor.scene);
  world.panes = std::move(floor.panes);
  world.landmarks = std::move(floor.landmarks);
  world.world_from_body = [drive](double time_s) { return drive->world_from_body(time_s); };
  world.duration_s = drive->duration_s();
  world.rate_hz = rate_hz;
  world.first_stamp = first_stamp;
  return world;
}

World make_corridor(const CorridorOptions& options) {
  if (!(options.scale >= 0.05 && options.scale <= 4.0))
    throw Error("the scale is out of range", "corridor", "use 0.05 to 4");
  World::Parts parts{
      "corridor",   corridor_camera(options.scale), corridor_path(), corridor_sensor, rate_hz, first_stamp,
      options.seed, corridor_body_from_camera()};
  corridor::Floor floor = corridor::build_floor(options.seed);
  TaskPool pool(options.threads);
  floor.scene->bake(seed_for(options.seed, 3), pool, std::min(1.0, options.scale), 0.5);
  return World(std::move(floor.scene), std::move(parts));
}

}  // namespace rastro
