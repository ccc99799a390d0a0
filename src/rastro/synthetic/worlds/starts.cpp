// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/starts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/synthetic/worlds/corridor_materials.h"
#include "rastro/synthetic/worlds/hall_materials.h"
#include "rastro/synthetic/worlds/street_materials.h"

namespace rastro {
namespace {

using Eigen::Vector3d;

constexpr double rate_hz = 20.0, degree = std::numbers::pi / 180.0;
constexpr double rotation_s = static_cast<double>(start_rotation_frames) / rate_hz;

// The camera starts at the origin and looks along x; y is to its left.

Material some_material(Random& random) {
  const float tone = static_cast<float>(random.uniform(70.0, 170.0));
  switch (random.below(5)) {
    case 0:
      return hall::cabinet(tone);
    case 1:
      return hall::wooden_crate();
    case 2:
      return hall::cardboard();
    case 3:
      return hall::brick_wall();
    default:
      return hall::machine(tone);
  }
}

/// Boxes between two distances in a fan in front of the camera, and a wall behind them all.
void add_boxes(Scene& scene, Random& random, double nearest, double farthest, int count, double size) {
  for (int i = 0; i < count; ++i) {
    const double away = random.uniform(nearest + 0.5 * size, farthest), angle = random.uniform(-0.7, 0.7);
    const Vector3d sides(size * random.uniform(0.4, 0.8), size * random.uniform(0.5, 1.0),
                         size * random.uniform(0.5, 1.2));
    scene.add_box({away, away * std::tan(angle), random.uniform(-0.35, 0.35) * away}, sides, some_material(random),
                  random.uniform(-0.6, 0.6));
  }
}

void add_wall(Scene& scene, double away, double half_width, const Material& material) {
  scene.add_quad({away, 0, 0}, {0, -2.0 * half_width, 0}, {0, 0, -1.6 * half_width}, material);
}

/// With a number of texels that suits its size.
Material for_distance(Material material, double away) {
  material.texels_per_meter = std::clamp(350.0 / away, 8.0, 300.0);
  return material;
}

void add_room(Scene& scene, Random& random, int signs) {
  const Material bare = hall::steel_beam(135.0F, 4.0);
  scene.add_box({4.05, 0, 0}, {0.1, 6.0, 3.0}, bare);
  for (const double side : {-1.0, 1.0}) scene.add_box({1.5, side * 2.55, 0}, {5.0, 0.1, 3.0}, bare);
  scene.add_box({1.5, 0, -1.35}, {5.0, 5.0, 0.1}, corridor::cloth(90.0F));
  scene.add_box({1.5, 0, 1.45}, {5.0, 5.0, 0.1}, bare);
  scene.add_box({2.9, 1.2, -0.9}, {0.7, 1.1, 0.8}, hall::cardboard());
  for (int i = 0; i < signs; ++i) {
    const double width = random.uniform(0.35, 0.6), z = random.uniform(-0.7, 0.9);
    if (i % 3 != 0)
      scene.add_box({4.0, random.uniform(-1.9, 1.9), z}, {0.08, width, 0.7 * width}, hall::sign(i % 2 == 0));
    else
      scene.add_box({random.uniform(2.6, 3.6), i % 2 == 0 ? 2.5 : -2.5, z}, {width, 0.08, 0.7 * width},
                    street::board());
  }
}

void fill_scene(Scene& scene, StartKind kind, int variation, Random& random) {
  const double v = static_cast<double>(variation);
  switch (kind) {
    case StartKind::planar: {
      const double away = 2.0 + 1.2 * v, aslant = 0.25 * v;
      const Material wall = variation != 1 ? hall::machine(120.0F, 100.0) : hall::brick_wall();
      scene.add_quad({away, 0, 0}, 5.0 * away * Vector3d(std::sin(aslant), -std::cos(aslant), 0), {0, 0, -3.0 * away},
                     for_distance(wall, away));
      return;
    }
    case StartKind::far:
      for (int i = 0; i < 14; ++i) {
        const double away = 18.0 + 1.5 * i + 2.0 * v, y = random.uniform(-0.7, 0.7) * away,
                     size = random.uniform(4.0, 8.0);
        scene.add_box({away + 4.0, y, 0.5 * size - 3.0}, {4.0, size, size},
                      for_distance(street::house_front(static_cast<float>(random.uniform(80, 150)), 2), away));
      }
      return add_wall(scene, 60.0, 80.0, for_distance(street::house_wall(110.0F, 6), 60.0));
    case StartKind::near:
      add_boxes(scene, random, 0.7, 1.5, 22, 0.35);
      return add_wall(scene, 1.8 + 0.2 * v, 2.5, hall::machine(120.0F));
    case StartKind::rotation_first:
      add_boxes(scene, random, 1.8 + 0.3 * v, 5.0, 30, 0.8);
      return add_wall(scene, 6.0, 12.0, for_distance(hall::brick_wall(), 4.0));
    case StartKind::low_texture:
      return add_room(scene, random, 9 - variation);
  }
}

/// m/s
Vector3d velocity_of(StartKind kind, int variation) {
  const Vector3d directions[] = {{0, 1, 0}, {0.3, -0.9, 0.2}, {0.1, 0.6, -0.6}, {0.6, 0.7, 0.1}};
  const double speeds[] = {1.0, 1.5, 0.3, 1.0, 0.6};
  const auto k = static_cast<std::size_t>(variation);
  return speeds[static_cast<std::size_t>(kind)] * directions[k];
}

CameraPath path_of(StartKind kind, int variation) {
  const Vector3d velocity = velocity_of(kind, variation);
  const bool rotates_first = kind == StartKind::rotation_first;
  return CameraPath([=](double time_s) {
    const double moving = rotates_first ? std::max(0.0, time_s - rotation_s) : time_s;
    const double rotation_time_s = rotates_first ? std::min(time_s, rotation_s) : 0.0;
    const double side = variation % 2 == 0 ? 1.0 : -1.0;
    // A yaw of 14 degrees there and back, or only there; later the hand trembles.
    const double yaw = variation < 2 ? 14.0 * std::sin(std::numbers::pi * rotation_time_s / rotation_s)
                                     : 14.0 * rotation_time_s / rotation_s;
    const double tremble = 0.4 * std::sin(5.0 * moving) + 0.2 * std::sin(11.0 * moving);
    return SE3(looking((side * yaw + tremble) * degree, 0.5 * tremble * degree, 0.3 * tremble * degree),
               moving * velocity);
  });
}

}  // namespace

const char* name_of(StartKind kind) {
  const char* const names[] = {"planar", "far", "near", "rotation first", "low texture"};
  return names[static_cast<std::size_t>(kind)];
}

World make_start(StartKind kind, int variation) {
  RASTRO_CHECK(variation >= 0 && variation < start_variations, "there is no such variation of a start");
  const std::uint64_t seed =
      seed_for(51, static_cast<std::uint64_t>(kind) * 16 + static_cast<std::uint64_t>(variation));
  Camera camera;
  camera.width = 320, camera.height = 240;
  camera.fx = camera.fy = 230.0, camera.cx = 159.5, camera.cy = 119.5;
  auto scene = std::make_unique<Scene>();
  Random random(seed);
  fill_scene(*scene, kind, variation, random);
  TaskPool pool(1);
  scene->bake(seed, pool, 1.0, 0.5);
  const auto sensor = [](double) {
    SensorModel model;
    model.exposure_time_s = 0.004;
    return model;
  };
  World::Parts parts{name_of(kind), camera, path_of(kind, variation), sensor, rate_hz, 1609459200000000000,
                     seed,          SE3()};
  return World(std::move(scene), std::move(parts));
}

}  // namespace rastro
