// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/rooms.h"

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/synthetic/worlds/room_scenes.h"

namespace rastro {
namespace {

constexpr TimeNs first_stamp = 1606800000000000000;

Camera room_camera(double scale) {
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 525.0, camera.cx = 319.5, camera.cy = 239.5;
  return scale == 1.0 ? camera : camera.scaled(scale);
}

SensorModel bedroom_sensor(double) {
  SensorModel sensor;
  sensor.exposure_time_s = 0.008;
  sensor.gain = 0.88F;
  sensor.vignette = 0.15F;
  sensor.read_noise = 1.6F;
  sensor.shot_noise = 0.03F;
  return sensor;
}

/// In less light the exposure is longer, and the image is still darker and noisier.
SensorModel study_sensor(double) {
  SensorModel sensor;
  sensor.exposure_time_s = 0.014;
  sensor.gain = 0.75F;
  sensor.vignette = 0.15F;
  sensor.read_noise = 2.6F;
  sensor.shot_noise = 0.06F;
  return sensor;
}

World make_room(const char* name, room::Room room, SensorModel (*sensor)(double), const RoomOptions& options) {
  if (!(options.scale >= 0.05 && options.scale <= 4.0)) throw Error("the scale is out of range", name, "use 0.05 to 4");
  TaskPool pool(options.threads);
  room.scene->bake(seed_for(options.seed, 3), pool, std::min(1.0, options.scale), 0.15);
  World::Parts parts{
      name, room_camera(options.scale), walk_path(room.walk), sensor, room::rate_hz, first_stamp, options.seed, SE3()};
  parts.in_color = true;
  parts.kinect = KinectModel();
  parts.lengths = std::move(room.lengths);
  return World(std::move(room.scene), std::move(parts));
}

}  // namespace

World make_bedroom(const RoomOptions& options) {
  return make_room("bedroom", room::build_bedroom(options.seed), bedroom_sensor, options);
}

World make_study(const RoomOptions& options) {
  return make_room("study", room::build_study(options.seed), study_sensor, options);
}

}  // namespace rastro
