// SPDX-License-Identifier: Apache-2.0
// The building of the campus from inside: two rings of corridors that look alike, and two flights of stairs.
#include <cmath>

#include "rastro/synthetic/worlds/campus_materials.h"
#include "rastro/synthetic/worlds/campus_plan.h"
#include "rastro/synthetic/worlds/campus_scene.h"
#include "rastro/synthetic/worlds/hall_materials.h"

namespace rastro::campus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double h = half_corridor, east = ring_x + h, north = ring_y + h;
constexpr double tower_east = 74.5, gallery_north = 4.5;

/// A horizontal rectangle in pieces of a bay along x or y, whichever is longer.
void add_level(Scene& scene, const Vector2d& low, const Vector2d& high, double z, const Material& material) {
  const Vector2d size = high - low;
  const bool along_x = size.x() >= size.y();
  const double length = along_x ? size.x() : size.y(), across = along_x ? size.y() : size.x();
  for (double begin = 0.0; begin < length - 1e-6; begin += bay_m) {
    const double piece = std::min(bay_m, length - begin), middle = begin + 0.5 * piece;
    const Vector3d center(low.x() + (along_x ? middle : 0.5 * across), low.y() + (along_x ? 0.5 * across : middle), z);
    const Vector3d along = along_x ? Vector3d(piece, 0, 0) : Vector3d(0, piece, 0);
    const Vector3d down = along_x ? Vector3d(0, -across, 0) : Vector3d(across, 0, 0);
    scene.add_quad(center, along, down, material);
  }
}

void add_ring(Scene& scene, int storey) {
  const double z = storey * storey_m;
  const auto level = [&](const Vector2d& low, const Vector2d& high) {
    add_level(scene, low, high, z, floor());
    add_level(scene, low, high, z + ceiling_m, ceiling());
  };
  level({-h, -h}, {east, h});
  level({-h, ring_y - h}, {east, north});
  level({-h, h}, {h, ring_y - h});
  level({ring_x - h, h}, {east, ring_y - h});
  for (const Wall& wall : corridor_walls(storey)) add_wall(scene, wall, plaster());
}

/// Doors in the middle of the bays, with the names beside them; windows instead in the connectors to the courtyard.
void add_doors(Scene& scene, const Wall& wall, bool windows) {
  for (double middle = 0.5 * bay_m; middle < wall.length() - 1.5; middle += bay_m) {
    if (!wall.closed(middle - 1.4, middle + 1.4)) continue;
    if (windows) {
      add_panel(scene, wall, middle, 1.75, {2.4, 1.3}, 0.02, view());
      add_panel(scene, wall, middle, 1.06, {2.5, 0.05}, 0.2, hall::steel_beam(170.0F));
      continue;
    }
    add_panel(scene, wall, middle, 1.06, {1.06, 2.12}, 0.05, door(20));
    add_panel(scene, wall, middle + 0.75, 1.62, {0.24, 0.24}, 0.02, door_sign());
  }
}

void add_extinguisher(Scene& scene, const Wall& wall, double distance) {
  scene.add_cylinder(wall.at(distance, 0.1, wall.low + 0.55), wall.at(distance, 0.1, wall.low + 1.05), 0.08,
                     hall::drum(70.0F));
  add_panel(scene, wall, distance, 1.75, {0.3, 0.3}, 0.02, hall::sign(false));
}

/// What hangs between the doors: each corridor has its own.
void add_notices(Scene& scene, Random& random, const Wall& wall) {
  for (double bay = 0.0; bay < wall.length() - 2.0; bay += bay_m)
    for (const double offset : {1.05, bay_m - 1.05}) {
      const double distance = bay + offset + random.uniform(-0.25, 0.25), kind = random.uniform();
      if (distance > wall.length() - 1.0 || !wall.closed(distance - 1.0, distance + 1.0)) continue;
      if (kind < 0.16)
        add_panel(scene, wall, distance, random.uniform(1.5, 1.7), {random.uniform(0.5, 0.7), 0.9}, 0.02, poster());
      else if (kind < 0.27)
        add_panel(scene, wall, distance, 1.6, {random.uniform(1.0, 1.4), 0.9}, 0.04, notice_board());
      else if (kind < 0.36)
        add_panel(scene, wall, distance, random.uniform(1.5, 1.8), {random.uniform(0.6, 1.1), 0.7}, 0.03, picture());
      else if (kind < 0.42)
        add_extinguisher(scene, wall, distance);
    }
}

/// From the wall of a corridor to the facade.
void add_passage(Scene& scene, const Vector2d& low, const Vector2d& high, bool along_y) {
  add_level(scene, low, high, 0.0, floor());
  add_level(scene, low, high, ceiling_m, ceiling());
  const Vector2d south_east(high.x(), low.y()), north_west(low.x(), high.y());
  if (along_y) {
    add_wall(scene, {low, north_west, 0.0, ceiling_m}, plaster());
    add_wall(scene, {high, south_east, 0.0, ceiling_m}, plaster());
  } else {
    add_wall(scene, {south_east, low, 0.0, ceiling_m}, plaster());
    add_wall(scene, {north_west, high, 0.0, ceiling_m}, plaster());
  }
}

void add_steps(Scene& scene, double x, double middle_y, bool up) {
  for (int i = 0; i < steps; ++i) {
    const double top = up ? rise_m * (i + 1) : storey_m - rise_m * (i + 1);
    if (top > 0.01)
      add_block(scene, {x + i * step_m, middle_y - h, 0.0}, {x + (i + 1) * step_m, middle_y + h, top}, tread());
  }
}

void add_stairs_up(Scene& scene, Random& random) {
  const double landing = stairs_up_x + stairs_m;
  const Wall south{{tower_east, -h}, {east, -h}, 0.0, top_m},
      end{{tower_east, gallery_north}, {tower_east, -h}, storey_m, top_m},
      back{{east, gallery_north}, {tower_east, gallery_north}, storey_m, top_m};
  for (const Wall& wall : {south, end, back, Wall{{east, h}, {tower_east, h}, 0.0, storey_m},
                           Wall{{east, -h}, {east, h}, ceiling_m, storey_m}})
    add_wall(scene, wall, plaster());
  add_steps(scene, stairs_up_x, 0.0, true);
  add_level(scene, {east, -h}, {stairs_up_x, h}, 0.0, floor());
  add_level(scene, {landing, -h}, {tower_east, gallery_north}, storey_m, floor());
  add_level(scene, {east, h}, {landing, gallery_north}, storey_m, floor());
  add_level(scene, {east, -h}, {tower_east, gallery_north}, top_m, ceiling());
  add_block(scene, {east, h - 0.08, storey_m}, {landing, h + 0.08, storey_m + 0.95}, hall::steel_beam(120.0F));
  add_panel(scene, end, 4.4, 1.5, {1.2, 1.5}, 0.04, picture());
  for (const Wall& wall : {south, back}) add_notices(scene, random, wall);
}

void add_stairs_down(Scene& scene, Random& random) {
  const Wall south{{outer_east - 0.05, ring_y - h}, {east, ring_y - h}, 0.0, top_m},
      north_side{{east, north}, {outer_east - 0.05, north}, 0.0, top_m};
  const Wall exit{{outer_east - 0.05, north}, {outer_east - 0.05, ring_y - h}, 0.0, top_m, {{0.3, 2.7, 2.4}}};
  for (const Wall& wall : {south, north_side, exit}) add_wall(scene, wall, plaster());
  add_steps(scene, stairs_down_x, ring_y, false);
  add_level(scene, {east, ring_y - h}, {stairs_down_x, north}, storey_m, floor());
  add_level(scene, {stairs_down_x + stairs_m - step_m, ring_y - h}, {outer_east, north}, 0.0, floor());
  add_level(scene, {east, ring_y - h}, {outer_east - 0.05, north}, top_m, ceiling());
  add_panel(scene, exit, 1.5, 4.2, {1.6, 1.2}, 0.02, view());
  add_panel(scene, south, 6.0, 2.6, {1.0, 1.2}, 0.03, poster());
  add_panel(scene, north_side, 8.0, 2.4, {1.2, 0.9}, 0.04, notice_board());
  add_notices(scene, random, south);
}

}  // namespace

std::vector<Wall> corridor_walls(int storey) {
  const double low = storey * storey_m, high = low + ceiling_m;
  std::vector<Wall> walls = {
      {{east, -h}, {-h, -h}, low, high},       {{h, h}, {ring_x - h, h}, low, high},
      {{-h, north}, {east, north}, low, high}, {{ring_x - h, ring_y - h}, {h, ring_y - h}, low, high},
      {{-h, -h}, {-h, north}, low, high},      {{h, ring_y - h}, {h, h}, low, high},
      {{east, north}, {east, -h}, low, high},  {{ring_x - h, h}, {ring_x - h, ring_y - h}, low, high}};
  if (storey == 0) {
    walls[0].openings = {{29.5, 33.5, ceiling_m}};
    walls[3].openings = {{27.0, 30.0, ceiling_m}};
    walls[6].openings = {{40.0, 43.0, ceiling_m}};
    walls[7].openings = {{9.0, 12.0, ceiling_m}};
  } else {
    walls[6].openings = {{0.0, 3.0, ceiling_m}, {37.3, 39.7, 2.4}};
  }
  return walls;
}

void add_building(Scene& scene, Random& random) {
  for (const int storey : {0, 1}) {
    add_ring(scene, storey);
    const std::vector<Wall> walls = corridor_walls(storey);
    for (std::size_t i = 0; i < walls.size(); ++i) {
      const bool windows = i == 5 || i == 7;  // Towards the courtyard.
      add_doors(scene, walls[i], windows);
      if (!windows) add_notices(scene, random, walls[i]);
    }
  }
  add_passage(scene, {28.0, outer_south}, {32.0, -h}, true);
  add_passage(scene, {28.5, court_north}, {31.5, ring_y - h}, true);
  add_passage(scene, {court_east, 10.5}, {ring_x - h, 13.5}, false);
  add_stairs_up(scene, random);
  add_stairs_down(scene, random);
}

std::uint32_t add_block(Scene& scene, const Vector3d& low, const Vector3d& high, const Material& material) {
  return scene.add_box(0.5 * (low + high), high - low, material);
}

void add_wall(Scene& scene, const Wall& wall, const Material& material) {
  const Vector2d along = wall.along();
  const auto add = [&](double begin, double end, double low, double high) {
    if (end - begin < 1e-6 || high - low < 1e-6) return;
    scene.add_quad(wall.at(0.5 * (begin + end), 0.0, 0.5 * (low + high)),
                   (end - begin) * Vector3d(along.x(), along.y(), 0.0), {0, 0, low - high}, material);
  };
  for (double begin = 0.0; begin < wall.length() - 1e-6; begin += bay_m) {
    const double end = std::min(begin + bay_m, wall.length());
    double from = begin;
    for (const Opening& opening : wall.openings) {
      const double cut = std::clamp(opening.begin, from, end), past = std::clamp(opening.end, from, end);
      if (past <= cut) continue;
      add(from, cut, wall.low, wall.high);
      add(cut, past, wall.low + opening.top, wall.high);
      from = past;
    }
    add(from, end, wall.low, wall.high);
  }
}

void add_panel(Scene& scene, const Wall& wall, double distance, double z, const Vector2d& size, double thick,
               const Material& material) {
  const Vector2d along = wall.along().cwiseAbs(), out = wall.out().cwiseAbs();
  const Vector2d plan = size.x() * along + 2.0 * thick * out;
  scene.add_box(wall.at(distance, 0.0, wall.low + z), {plan.x(), plan.y(), size.y()}, material);
}

}  // namespace rastro::campus
