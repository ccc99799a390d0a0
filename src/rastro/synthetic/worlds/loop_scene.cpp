// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/loop_scene.h"

#include "rastro/synthetic/worlds/corridor_materials.h"
#include "rastro/synthetic/worlds/hall_materials.h"
#include "rastro/synthetic/worlds/street_materials.h"

namespace rastro::loop {
namespace {

using Eigen::Vector3d;

Material denser(Material material, double texels_per_meter) {
  material.texels_per_meter = texels_per_meter;
  return material;
}

struct House {
  Vector3d low, high;
  float tone;
};

// The big house in the middle and the small one south of it are walked around; the others close the view.
const House houses[] = {
    {{4.0, 4.0, 0}, {18.0, 10.4, 7.0}, 128.0F},     {{3.0, -6.4, 0}, {9.2, -3.2, 5.4}, 104.0F},
    {{15.0, -14.0, 0}, {26.0, -3.6, 8.0}, 138.0F},  {{26.0, -14.0, 0}, {32.0, 3.0, 7.0}, 98.0F},
    {{26.0, 3.0, 0}, {32.0, 12.5, 9.0}, 142.0F},    {{26.0, 12.5, 0}, {32.0, 26.0, 6.5}, 112.0F},
    {{19.0, 20.0, 0}, {26.0, 26.0, 8.0}, 124.0F},   {{-14.0, -3.0, 0}, {-8.0, 5.6, 7.5}, 118.0F},
    {{-14.0, 5.6, 0}, {-8.0, 13.0, 9.5}, 146.0F},   {{-14.0, 13.0, 0}, {-8.0, 20.0, 6.5}, 92.0F},
    {{-8.0, 20.0, 0}, {3.0, 26.0, 7.5}, 132.0F},    {{-14.0, -13.0, 0}, {-5.0, -3.0, 6.0}, 110.0F},
    {{-12.0, -19.0, 0}, {3.0, -13.0, 7.0}, 136.0F}, {{3.0, -19.0, 0}, {15.0, -13.0, 8.5}, 102.0F},
};

void add_house(Scene& scene, const House& house) {
  const int floors = static_cast<int>(house.high.z() / 3.0);
  const Material front = denser(street::house_front(house.tone, floors), 80.0);
  const std::uint32_t body = add_block(scene, house.low, house.high, front);
  for (const int hidden : {4, 5}) scene.paint_face(body, hidden, street::plain(60.0F));
}

void add_ground(Scene& scene) {
  const double piece = 6.0;
  for (double x = -9.0; x < 27.0; x += piece)
    for (double y = -15.0; y < 21.0; y += piece)
      scene.add_quad({x + 0.5 * piece, y + 0.5 * piece, 0.0}, {piece, 0, 0}, {0, -piece, 0}, street::pavement());
  const double reach = 150.0, low = -4.0, high = 70.0, z = 0.5 * (low + high), height = high - low;
  scene.add_quad({0, 0, -0.03}, {2 * reach, 0, 0}, {0, -2 * reach, 0}, street::grass());
  for (const double side : {-1.0, 1.0}) {
    scene.add_quad({side * reach, 0, z}, {0, -side * 2 * reach, 0}, {0, 0, -height}, street::sky(-low));
    scene.add_quad({0, side * reach, z}, {side * 2 * reach, 0, 0}, {0, 0, -height}, street::sky(-low));
  }
  scene.add_quad({0, 0, high}, {2 * reach, 0, 0}, {0, 2 * reach, 0}, street::sky_top());
}

/// The hall north of the big house, open at both ends.
void add_hall(Scene& scene, Random& random) {
  constexpr double west = 3.0, east = 19.0, south = 11.0, north = 17.0, ceiling = 3.8, thick = 0.4;
  for (double x = west; x < east; x += 8.0) {
    add_block(scene, {x, south - 0.6, 0}, {x + 8.0, south, ceiling}, denser(corridor::wall(false), 80.0));
    add_block(scene, {x, north, 0}, {x + 8.0, north + thick, ceiling}, denser(hall::brick_wall(), 80.0));
    add_block(scene, {x, south - 0.6, ceiling}, {x + 8.0, north + thick, ceiling + thick}, hall::ceiling_sheet());
    scene.add_quad({x + 4.0, 0.5 * (south + north), 0.004}, {8.0, 0, 0}, {0, south - north, 0},
                   denser(hall::concrete_floor(), 90.0));
  }
  for (const double x : {west, east - thick}) {
    add_block(scene, {x, south, 0}, {x + thick, south + 1.3, ceiling}, denser(hall::brick_wall(), 90.0));
    add_block(scene, {x, north - 1.3, 0}, {x + thick, north, ceiling}, denser(hall::brick_wall(), 90.0));
    add_block(scene, {x, south + 1.3, 3.1}, {x + thick, north - 1.3, ceiling}, hall::steel_beam(90.0F));
  }
  for (double x = west + 2.6; x < east - 1.0; x += 3.6) {
    scene.add_cylinder({x, south + 1.1, 0}, {x, south + 1.1, ceiling}, 0.2, denser(hall::concrete_pillar(), 150.0));
    scene.add_cylinder({x + 1.2, north - 1.1, 0}, {x + 1.2, north - 1.1, ceiling}, 0.2,
                       denser(hall::concrete_pillar(), 150.0));
    add_block(scene, {x + 0.7, south, 0}, {x + 2.6, south + random.uniform(0.5, 0.9), random.uniform(1.0, 2.2)},
              hall::machine(static_cast<float>(random.uniform(80, 150)), 120.0));
    add_block(scene, {x - 1.2, north - random.uniform(0.4, 0.7), 0}, {x + 0.7, north, random.uniform(1.4, 2.4)},
              denser(hall::cabinet(static_cast<float>(random.uniform(70, 170))), 120.0));
  }
}

/// An area of the square that is seen on both visits.
void add_fountain(Scene& scene) {
  scene.add_cylinder({-4.2, 8.0, 0}, {-4.2, 8.0, 0.7}, 1.2, denser(hall::concrete_pillar(), 120.0));
  scene.add_cylinder({-4.2, 8.0, 0.7}, {-4.2, 8.0, 2.2}, 0.3, denser(hall::concrete_pillar(), 160.0));
  scene.add_sphere({-4.2, 8.0, 2.5}, 0.45, hall::tank(120.0F));
  for (const double y : {3.4, 12.2}) {
    add_block(scene, {-6.4, y - 0.9, 0}, {-5.2, y + 0.9, 0.6}, denser(hall::brick_wall(), 120.0));
    scene.add_sphere({-5.8, y, 1.15}, 0.65, denser(street::foliage(70.0F), 90.0));
  }
}

/// The location of the kidnap: a closed room far from the walk.
void add_elsewhere(Scene& scene) {
  const Vector3d low = elsewhere_position - Vector3d(2.2, 2.5, elsewhere_position.z()),
                 high = low + Vector3d(6.5, 6.0, 3.0);
  const double t = 0.2;
  add_block(scene, {high.x(), low.y(), 0}, {high.x() + t, high.y(), high.z()}, corridor::wall(false));
  add_block(scene, {low.x() - t, low.y(), 0}, {low.x(), high.y(), high.z()}, corridor::wall(false));
  add_block(scene, {low.x(), high.y(), 0}, {high.x(), high.y() + t, high.z()}, corridor::wall(false));
  add_block(scene, {low.x(), low.y() - t, 0}, {high.x(), low.y(), high.z()}, corridor::wall(false));
  add_block(scene, {low.x(), low.y(), 0.0}, {high.x(), high.y(), 0.01}, corridor::carpet());
  add_block(scene, {low.x(), low.y(), high.z()}, {high.x(), high.y(), high.z() + t}, corridor::ceiling());
  const Vector3d far_corner(high.x(), high.y(), 0);
  add_block(scene, far_corner - Vector3d(0.6, 2.0, 0), far_corner + Vector3d(0, -0.6, 1.9), corridor::wood(110.0F));
  add_block(scene, far_corner - Vector3d(1.0, 4.6, 0), far_corner + Vector3d(-0.2, -3.0, 0.75), corridor::wood(150.0F));
  add_block(scene, far_corner + Vector3d(-0.8, -4.2, 0.75), far_corner + Vector3d(-0.4, -3.5, 1.15), hall::cardboard());
}

}  // namespace

std::uint32_t add_block(Scene& scene, const Vector3d& low, const Vector3d& high, const Material& material) {
  return scene.add_box(0.5 * (low + high), high - low, material);
}

std::unique_ptr<Scene> build_scene(std::uint64_t seed, int threads, double detail) {
  auto scene = std::make_unique<Scene>();
  Random random(seed_for(seed, 41));
  add_ground(*scene);
  for (const House& house : houses) add_house(*scene, house);
  add_hall(*scene, random);
  add_fountain(*scene);
  add_signs(*scene, random);
  add_things(*scene, random);
  add_elsewhere(*scene);
  add_crowd(*scene);
  TaskPool pool(threads);
  scene->bake(seed_for(seed, 42), pool, detail, 0.6);
  return scene;
}

}  // namespace rastro::loop
