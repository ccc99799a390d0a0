// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/room_things.h"

#include <algorithm>
#include <cmath>

#include "rastro/synthetic/worlds/room_materials.h"

namespace rastro::room {
namespace {

using Eigen::Vector3d;

constexpr double wall_m = 0.1;
constexpr Color covers[] = {{150, 48, 44},  {44, 72, 120},   {60, 100, 66}, {196, 168, 96},
                            {92, 62, 92},   {210, 204, 190}, {52, 52, 58},  {176, 102, 52},
                            {88, 126, 140}, {128, 120, 60},  {120, 70, 50}, {160, 160, 165}};

Material any_book(Random& random) { return book(covers[random.below(std::size(covers))]); }

std::uint32_t between(Scene& scene, const Vector3d& a, const Vector3d& b, const Material& material) {
  return add_block(scene, a.cwiseMin(b), a.cwiseMax(b), material);
}

}  // namespace

std::uint32_t add_block(Scene& scene, const Vector3d& low, const Vector3d& high, const Material& material) {
  return scene.add_box(0.5 * (low + high), high - low, material);
}

void add_shell(Scene& scene, const Shell& shell) {
  const Vector3d &low = shell.low, &high = shell.high;
  add_block(scene, {high.x(), low.y(), 0.0}, {high.x() + wall_m, high.y(), high.z()}, shell.walls[0]);
  add_block(scene, {low.x(), high.y(), 0.0}, {high.x(), high.y() + wall_m, high.z()}, shell.walls[1]);
  add_block(scene, {low.x() - wall_m, low.y(), 0.0}, {low.x(), high.y(), high.z()}, shell.walls[2]);
  add_block(scene, {low.x(), low.y() - wall_m, 0.0}, {high.x(), low.y(), high.z()}, shell.walls[3]);
  const Vector3d middle = 0.5 * (low + high), size = high - low;
  scene.add_quad({middle.x(), middle.y(), 0.0}, {size.x(), 0, 0}, {0, -size.y(), 0}, shell.floor);
  scene.add_quad({middle.x(), middle.y(), high.z()}, {size.x(), 0, 0}, {0, size.y(), 0}, ceiling_paint());
}

void add_books(Scene& scene, Random& random, const BookRow& row) {
  double at = 0.0;
  while (true) {
    const double thick = random.uniform(0.012, 0.045), height = row.height * random.uniform(0.68, 1.0),
                 deep = random.uniform(0.12, 0.17), back = random.uniform(0.0, 0.03);
    if (at + thick > row.length) return;
    const Vector3d from = row.from + at * row.along + back * row.inward;
    between(scene, from, from + thick * row.along + deep * row.inward + Vector3d(0, 0, height), any_book(random));
    at += thick + (random.uniform() < 0.1 ? random.uniform(0.02, 0.06) : 0.001);
  }
}

void add_pile(Scene& scene, Random& random, const Vector3d& at, int books) {
  double z = at.z();
  for (int i = 0; i < books; ++i) {
    const double thick = random.uniform(0.015, 0.045);
    scene.add_box({at.x(), at.y(), z + 0.5 * thick}, {random.uniform(0.15, 0.19), random.uniform(0.2, 0.26), thick},
                  any_book(random), random.uniform(-0.3, 0.3));
    z += thick;
  }
}

void add_bookcase(Scene& scene, const Bookcase& bookcase) {
  const Vector3d &low = bookcase.low, &high = bookcase.high;
  for (const double y : {low.y(), high.y() - board_m})
    add_block(scene, {low.x(), y, low.z()}, {high.x(), y + board_m, high.z()}, bookcase.material);
  add_block(scene, {high.x() - 0.01, low.y() + board_m, low.z()}, {high.x(), high.y() - board_m, high.z()},
            bookcase.material);
  for (const double top : bookcase.boards)
    add_block(scene, {low.x(), low.y() + board_m, top - board_m}, {high.x() - 0.01, high.y() - board_m, top},
              bookcase.material);
}

void add_table(Scene& scene, const Vector3d& low, const Vector3d& high, const Material& top) {
  add_block(scene, {low.x(), low.y(), high.z() - 0.03}, high, top);
  for (const double x : {low.x() + 0.02, high.x() - 0.07})
    for (const double y : {low.y() + 0.02, high.y() - 0.07})
      add_block(scene, {x, y, low.z()}, {x + 0.05, y + 0.05, high.z() - 0.03}, top);
}

void add_chair(Scene& scene, const Vector3d& at, double yaw, const Material& cover) {
  const Vector3d forward(std::cos(yaw), std::sin(yaw), 0.0), left(-forward.y(), forward.x(), 0.0);
  scene.add_box(at + Vector3d(0, 0, 0.44), {0.42, 0.42, 0.06}, cover, yaw);
  scene.add_box(at - 0.19 * forward + Vector3d(0, 0, 0.72), {0.04, 0.40, 0.36}, cover, yaw);
  for (const double a : {-0.18, 0.18})
    for (const double b : {-0.18, 0.18}) {
      const Vector3d foot = at + a * forward + b * left;
      scene.add_cylinder(foot, foot + Vector3d(0, 0, 0.42), 0.018, metal({92, 92, 96}));
    }
}

void add_plant(Scene& scene, Random& random, const Vector3d& at, double size) {
  scene.add_cylinder(at, at + Vector3d(0, 0, 0.45 * size), 0.26 * size, varnish({168, 88, 58}));
  for (int i = 0; i < 7; ++i) {
    const Vector3d offset(random.uniform(-0.25, 0.25), random.uniform(-0.25, 0.25), random.uniform(0.55, 1.05));
    scene.add_sphere(at + size * offset, size * random.uniform(0.14, 0.24), leaves());
  }
}

void add_lamp(Scene& scene, const Vector3d& foot, double height) {
  scene.add_cylinder(foot, foot + Vector3d(0, 0, 0.03), 0.10, metal({70, 70, 74}));
  scene.add_cylinder(foot + Vector3d(0, 0, 0.03), foot + Vector3d(0, 0, height - 0.2), 0.012, metal({120, 110, 90}));
  scene.add_cylinder(foot + Vector3d(0, 0, height - 0.2), foot + Vector3d(0, 0, height), 0.11, lamp({246, 226, 176}));
}

NamedLength box_length(const std::string& name, const Vector3d& low, const Vector3d& high, int across, int along,
                       const Vector3d& normal) {
  NamedLength length;
  length.name = name;
  length.length_m = high[across] - low[across];
  length.face = 0.5 * (low + high) + 0.5 * normal.cwiseProduct(high - low);
  length.a.middle = length.b.middle = length.face;
  length.a.middle[across] = low[across], length.b.middle[across] = high[across];
  length.a.direction = length.b.direction = Vector3d::Unit(along);
  return length;
}

}  // namespace rastro::room
