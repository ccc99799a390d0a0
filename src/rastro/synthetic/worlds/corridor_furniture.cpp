// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "rastro/synthetic/worlds/corridor_materials.h"
#include "rastro/synthetic/worlds/corridor_scene.h"

namespace rastro::corridor {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

float some(Random& random, double low, double high) { return static_cast<float>(random.uniform(low, high)); }

void upright(Scene& scene, const Vector2d& at, double z0, double z1, double radius, const Material& material) {
  scene.add_cylinder({at.x(), at.y(), z0}, {at.x(), at.y(), z1}, radius, material);
}

/// On four legs: the laser sees only the legs.
void add_table(Scene& scene, const Vector2d& middle, const Vector2d& size, double yaw, float tone) {
  const Vector2d x(std::cos(yaw), std::sin(yaw)), y(-x.y(), x.x());
  scene.add_box({middle.x(), middle.y(), 0.72}, {size.x(), size.y(), 0.04}, wood(tone), yaw);
  for (const double a : {-0.46, 0.46})
    for (const double b : {-0.42, 0.42})
      upright(scene, middle + a * size.x() * x + b * size.y() * y, 0.0, 0.70, 0.03, metal(90.0F));
}

void add_chair(Scene& scene, const Vector2d& at, double yaw) {
  upright(scene, at, 0.0, 0.42, 0.04, metal(80.0F));
  scene.add_box({at.x(), at.y(), 0.45}, {0.45, 0.45, 0.06}, cloth(70.0F), yaw);
  const Vector2d back = at + 0.22 * Vector2d(std::cos(yaw), std::sin(yaw));
  scene.add_box({back.x(), back.y(), 0.75}, {0.05, 0.42, 0.5}, cloth(70.0F), yaw);
}

struct Room {
  double west, south, east, north;
  bool cupboards_south;  ///< Along which wall; the door is in the other.
};

/// Cupboards of different depths along the wall opposite to the door.
void add_cupboards(Scene& scene, Random& random, const Room& room) {
  double x = room.west + random.uniform(0.1, 0.8);
  while (x < room.east - 1.3) {
    const double width = random.uniform(0.7, 1.2), depth = random.uniform(0.3, 0.6), height = random.uniform(0.9, 2.0);
    const double south = room.cupboards_south ? room.south : room.north - depth;
    add_block(scene, {x, south, 0.0}, {x + width, south + depth, height}, metal(some(random, 100, 170)));
    x += width + (random.uniform() < 0.5 ? 0.0 : random.uniform(0.4, 1.5));
  }
}

void add_desks(Scene& scene, Random& random, const Room& room) {
  const double middle_y = 0.5 * (room.south + room.north) + (room.cupboards_south ? -0.2 : 0.2);
  for (double x = room.west + 1.2; x < room.east - 1.0; x += random.uniform(2.2, 2.9)) {
    const Vector2d at(x, middle_y + random.uniform(-0.5, 0.5));
    add_table(scene, at, {1.6, 0.8}, random.uniform(-0.25, 0.25), some(random, 120, 180));
    add_chair(scene, at + Vector2d(random.uniform(-0.4, 0.4), room.cupboards_south ? -0.8 : 0.8),
              random.uniform(0.0, 6.0));
    if (random.uniform() < 0.5) upright(scene, at + Vector2d(1.0, 0.4), 0.0, 0.4, 0.15, metal(110.0F));
  }
}

/// The robot's path, north of its table.
void add_meeting_room(Scene& scene, Random& random) {
  add_table(scene, {15.0, -4.7}, {4.0, 1.2}, 0.0, 150.0F);
  for (const double x : {13.6, 14.7, 15.8, 16.5})
    add_chair(scene, {x + random.uniform(-0.1, 0.1), -3.85}, random.uniform(1.2, 1.9));
  add_block(scene, {13.9, -1.75, 0.0}, {16.0, -1.15, 0.9}, wood(110.0F));
  upright(scene, {20.3, -5.3}, 0.0, 0.5, 0.22, metal(100.0F));
  scene.add_sphere({20.3, -5.3, 1.0}, 0.45, leaves());
  add_block(scene, {11.2, -5.5, 0.0}, {11.6, -3.9, 1.8}, metal(130.0F));
}

/// Not in the long corridor in the north: that one stays bare.
void add_corridor_things(Scene& scene) {
  add_block(scene, {1.9, 0.84, 0.0}, {2.3, 1.0, ceiling_m}, wall(true));
  add_block(scene, {-2.6, 0.45, 0.0}, {-1.9, 1.0, 1.1}, metal(190.0F));
  add_block(scene, {6.8, -1.0, 0.0}, {7.2, -0.84, ceiling_m}, wall(true));
  upright(scene, {11.2, 0.72}, 0.0, 0.45, 0.20, metal(120.0F));
  scene.add_sphere({11.2, 0.72, 0.95}, 0.26, leaves());
  upright(scene, {14.3, 0.90}, 0.25, 0.9, 0.08, metal(60.0F));
  add_block(scene, {20.55, 0.3, 0.0}, {21.0, 1.7, 0.45}, wood(100.0F));
  add_block(scene, {20.84, 4.6, 0.0}, {21.0, 5.0, ceiling_m}, wall(true));
  add_block(scene, {-9.0, 3.0, 0.0}, {-8.6, 4.0, 1.9}, metal(120.0F));
  add_block(scene, {-7.16, 5.2, 0.0}, {-7.0, 5.6, ceiling_m}, wall(true));
}

/// A person at a time and position.
struct Step {
  double time_s, x, y;
};

// A walk of at most 1.3 m/s, kept clear of the robot, as the world's test checks.
constexpr Step walk[] = {
    {0.0, 5.0, -3.0},   {3.0, 5.0, -3.0},   {7.5, 5.0, 2.5},    {20.0, 5.0, 2.5},    {22.0, 5.0, 0.0},
    {33.0, -8.0, 0.0},  {39.0, -8.0, 6.5},  {80.0, -8.0, 6.5},  {81.5, -7.5, 8.5},   {103.0, 18.5, 8.5},
    {105.0, 20.0, 7.5}, {112.0, 20.0, 0.6}, {135.0, -6.0, 0.6}, {136.0, -6.0, -0.6}, {139.0, -6.0, -3.5},
};

Vector2d person_at(double time_s) {
  const Step* next = std::upper_bound(std::begin(walk), std::end(walk), time_s,
                                      [](double time, const Step& step) { return time < step.time_s; });
  if (next == std::begin(walk)) return {next->x, next->y};
  const Step& before = *(next - 1);
  if (next == std::end(walk)) return {before.x, before.y};
  const double share = (time_s - before.time_s) / (next->time_s - before.time_s);
  return {before.x + share * (next->x - before.x), before.y + share * (next->y - before.y)};
}

SE3 person_pose(double time_s) {
  const Vector2d at = person_at(time_s), ahead = person_at(time_s + 0.4) - person_at(time_s - 0.4);
  const double heading = ahead.norm() > 1e-9 ? std::atan2(ahead.y(), ahead.x()) : 0.0;
  return {SO3::exp({0, 0, heading}), {at.x(), at.y(), 0.0}};
}

/// Steps of 0.7 m while walking; a foot swings 0.2 m ahead of the body and as far behind it.
Motion leg_motion(double side) {
  return [side](double time_s) {
    const double speed = (person_at(time_s + 0.1) - person_at(time_s - 0.1)).norm() / 0.2;
    const double swing = std::min(1.0, speed) * 0.2 * std::sin(std::numbers::pi * time_s * 1.8);
    return person_pose(time_s) * SE3(SO3(), {side * swing, 0.0, 0.0});
  };
}

}  // namespace

void add_furniture(Scene& scene, Random& random) {
  constexpr double t = 0.15;  // Of the walls.
  const std::array<Room, 7> rooms = {Room{inner_west + t, inner_south + t, -1.0 - t, inner_north - t, false},
                                     Room{-1.0, inner_south + t, 6.0 - t, inner_north - t, false},
                                     Room{6.0, inner_south + t, 12.0 - t, inner_north - t, false},
                                     Room{12.0, inner_south + t, inner_east - t, inner_north - t, false},
                                     Room{outer_west + t, far_south, -3.0, outer_south - t, true},
                                     Room{-3.0 + t, far_south, 3.0, outer_south - t, true},
                                     Room{3.0 + t, far_south, 11.0, outer_south - t, true}};
  for (const Room& room : rooms) {
    add_cupboards(scene, random, room);
    add_desks(scene, random, room);
  }
  add_meeting_room(scene, random);
  for (const Room& room : {Room{far_west, outer_south, outer_west - t, 4.0 - t, true},
                           Room{outer_east + t, outer_south, far_east, 5.0 - t, true}}) {
    add_cupboards(scene, random, room);
    const Vector2d middle(0.5 * (room.west + room.east), 0.5 * (room.south + room.north));
    add_table(scene, middle, {1.6, 0.8}, random.uniform(1.2, 1.9), 140.0F);
    add_chair(scene, middle + Vector2d(0.1, 1.2), random.uniform(0.0, 6.0));
  }
  add_corridor_things(scene);
}

void add_person(Scene& scene) {
  scene.begin_moving(person_pose);
  upright(scene, {0, 0}, 0.80, 1.45, 0.19, cloth(60.0F));
  scene.add_sphere({0, 0, 1.62}, 0.13, skin());
  for (const double side : {-1.0, 1.0}) {
    scene.begin_moving(leg_motion(side));
    upright(scene, {0.0, side * 0.11}, 0.0, 0.82, 0.075, cloth(40.0F));
  }
}

}  // namespace rastro::corridor
