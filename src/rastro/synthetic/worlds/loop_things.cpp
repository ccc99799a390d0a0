// SPDX-License-Identifier: Apache-2.0
// Objects along the path of the loop and on its walls.
#include <algorithm>
#include <numbers>

#include "rastro/synthetic/worlds/hall_materials.h"
#include "rastro/synthetic/worlds/loop_scene.h"
#include "rastro/synthetic/worlds/street_materials.h"

namespace rastro::loop {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector3d at(const Vector2d& position, double z) { return {position.x(), position.y(), z}; }
float tone_of(Random& random) { return static_cast<float>(random.uniform(60.0, 185.0)); }

void add_crates(Scene& scene, Random& random, const Vector2d& position) {
  double z = 0.0, size = random.uniform(0.6, 0.9);
  for (int i = 0; i < 3 && size > 0.3; ++i) {
    const Material material = random.uniform() < 0.5 ? hall::wooden_crate() : hall::cardboard();
    scene.add_box(at(position, z + 0.5 * size), {size, size, size}, material, random.uniform(-0.5, 0.5));
    z += size;
    size *= random.uniform(0.6, 0.95);
  }
}

void add_drums(Scene& scene, Random& random, const Vector2d& position) {
  for (const double side : {-0.31, 0.31}) {
    const Vector2d here = position + side * Vector2d(1.0, random.uniform(-0.3, 0.3));
    const float tone = tone_of(random);
    const std::uint32_t drum = scene.add_cylinder(at(here, 0), at(here, 0.9), 0.29, hall::drum(tone));
    scene.paint_face(drum, 1, hall::lid(tone));
  }
}

/// A column for notices.
void add_column(Scene& scene, Random& random, const Vector2d& position) {
  scene.add_cylinder(at(position, 0), at(position, 2.5), 0.42, hall::tank(tone_of(random)));
  scene.add_cylinder(at(position, 2.5), at(position, 2.65), 0.5, street::pole(80.0F));
}

void add_board(Scene& scene, Random& random, const Vector2d& position) {
  const double yaw = random.uniform(0.0, std::numbers::pi);
  scene.add_cylinder(at(position, 0), at(position, 2.3), 0.05, street::pole(110.0F));
  scene.add_box(at(position, 1.75), {0.9, 0.05, 0.6}, street::board(), yaw);
}

void add_tub(Scene& scene, Random& random, const Vector2d& position) {
  scene.add_box(at(position, 0.3), {0.9, 0.6, 0.6}, hall::brick_wall(), random.uniform(-0.2, 0.2));
  scene.add_sphere(at(position, 0.95), random.uniform(0.4, 0.5), street::foliage(tone_of(random)));
}

void add_locker(Scene& scene, Random& random, const Vector2d& position) {
  const double height = random.uniform(1.1, 1.9);
  scene.add_box(at(position, 0.5 * height), {0.9, 0.6, height}, hall::cabinet(tone_of(random)),
                random.uniform(-0.2, 0.2));
}

/// Objects of all kinds side by side, about 1.9 m apart.
struct Row {
  Vector2d from, to;
};
const Row rows[] = {
    {{4.6, 3.1}, {17.4, 3.1}},   {{4.0, -2.4}, {8.6, -2.4}},    {{15.6, -2.8}, {25.0, -2.8}},
    {{25.2, 1.0}, {25.2, 18.6}}, {{18.8, 4.6}, {18.8, 9.6}},    {{20.0, 18.8}, {24.0, 18.8}},
    {{-7.2, -1.8}, {-7.2, 2.0}}, {{-7.2, 14.4}, {-7.2, 18.8}},  {{-5.0, 19.2}, {2.0, 19.2}},
    {{3.2, 4.4}, {3.2, 9.6}},    {{14.3, -4.6}, {14.3, -12.0}}, {{-0.6, -12.2}, {12.6, -12.2}},
    {{3.8, -7.0}, {8.4, -7.0}},  {{-4.3, -4.0}, {-4.3, -11.0}}, {{2.3, -3.6}, {2.3, -5.8}},
};

/// A wall along one of the axes with signs on it, `out` pointing away from it.
struct Wall {
  Vector2d from, to, out;
  double top;
};
const Wall walls[] = {
    {{18.0, 4.0}, {4.0, 4.0}, {0, -1}, 3.0},     {{9.2, -3.2}, {3.0, -3.2}, {0, 1}, 3.0},
    {{18.0, 4.0}, {18.0, 10.4}, {1, 0}, 3.0},    {{4.0, 10.4}, {4.0, 4.0}, {-1, 0}, 3.0},
    {{26.0, -3.0}, {26.0, 19.5}, {-1, 0}, 3.4},  {{15.0, -3.6}, {25.8, -3.6}, {0, 1}, 3.2},
    {{-8.0, 19.5}, {-8.0, -2.5}, {1, 0}, 4.2},   {{15.0, -13.0}, {15.0, -4.0}, {-1, 0}, 3.0},
    {{-4.0, -13.0}, {14.0, -13.0}, {0, 1}, 3.2}, {{3.0, -6.4}, {9.0, -6.4}, {0, -1}, 2.8},
    {{-5.0, -12.0}, {-5.0, -3.2}, {1, 0}, 3.0},  {{-7.0, 20.0}, {2.6, 20.0}, {0, -1}, 3.4},
    {{19.5, 20.0}, {25.5, 20.0}, {0, -1}, 3.4},  {{9.2, -3.5}, {9.2, -6.2}, {1, 0}, 2.8},
    {{3.6, 11.0}, {18.4, 11.0}, {0, 1}, 3.3},    {{3.6, 17.0}, {18.4, 17.0}, {0, -1}, 3.4},
};

Material sign_material(Random& random) {
  switch (random.below(4)) {
    case 0:
      return hall::sign(false);
    case 1:
      return hall::sign(true);
    case 2:
      return street::board();
    default:
      return hall::machine(tone_of(random), 110.0, 0.25);
  }
}

}  // namespace

void add_signs(Scene& scene, Random& random) {
  for (const Wall& wall : walls) {
    const Vector2d along = (wall.to - wall.from).normalized();
    const double length = (wall.to - wall.from).norm();
    for (double distance = random.uniform(0.5, 1.0); distance < length - 0.6; distance += random.uniform(1.2, 2.2)) {
      const double width = random.uniform(0.5, 1.1), height = width * random.uniform(0.5, 1.3);
      const double z = random.uniform(1.0 + 0.5 * height, wall.top - 0.5 * height);
      // Never coplanar with the wall or with each other.
      const Vector2d middle = wall.from + distance * along + random.uniform(0.01, 0.03) * wall.out;
      const Vector2d size = width * along.cwiseAbs() + 0.09 * wall.out.cwiseAbs();
      scene.add_box(at(middle, z), {size.x(), size.y(), height}, sign_material(random));
    }
  }
}

void add_things(Scene& scene, Random& random) {
  using Add = void (*)(Scene&, Random&, const Vector2d&);
  constexpr Add kinds[] = {add_crates, add_drums, add_column, add_board, add_tub, add_locker};
  for (const Row& row : rows) {
    const Vector2d along = (row.to - row.from).normalized();
    const double length = (row.to - row.from).norm();
    for (double distance = random.uniform(0.0, 0.5); distance < length; distance += random.uniform(1.5, 2.3))
      kinds[random.below(std::size(kinds))](scene, random, row.from + distance * along);
  }
}

}  // namespace rastro::loop
