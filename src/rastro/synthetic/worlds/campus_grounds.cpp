// SPDX-License-Identifier: Apache-2.0
// The campus from outside: facades, parking lot, courtyard, houses and trees around.
#include <numbers>

#include "rastro/synthetic/worlds/campus_materials.h"
#include "rastro/synthetic/worlds/campus_plan.h"
#include "rastro/synthetic/worlds/campus_scene.h"
#include "rastro/synthetic/worlds/hall_materials.h"
#include "rastro/synthetic/worlds/street_materials.h"

namespace rastro::campus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

void add_facades(Scene& scene) {
  const Wall outside[] = {
      {{outer_west, outer_south}, {outer_east, outer_south}, 0.0, roof_m, {{34.0, 38.0, ceiling_m}}},
      {{outer_east, outer_south}, {outer_east, outer_north}, 0.0, roof_m, {{44.8, 47.2, 2.4}}},
      {{outer_east, outer_north}, {outer_west, outer_north}, 0.0, roof_m},
      {{outer_west, outer_north}, {outer_west, outer_south}, 0.0, roof_m},
  };
  const Wall inside[] = {
      {{court_east, court_south}, {court_west, court_south}, 0.0, roof_m},
      {{court_west, court_north}, {court_east, court_north}, 0.0, roof_m, {{22.5, 25.5, ceiling_m}}},
      {{court_west, court_south}, {court_west, court_north}, 0.0, roof_m},
      {{court_east, court_north}, {court_east, court_south}, 0.0, roof_m, {{20.5, 23.5, ceiling_m}}},
  };
  for (const Wall& wall : outside) add_wall(scene, wall, [](int) { return facade(true); });
  for (const Wall& wall : inside) add_wall(scene, wall, [](int) { return facade(false); });
  // Signs at the doors.
  add_panel(scene, outside[0], 33.0, 1.7, {0.9, 1.2}, 0.04, street::board());
  add_panel(scene, outside[0], 36.0, 3.3, {3.4, 0.6}, 0.06, hall::sign(false));
  add_panel(scene, outside[1], 48.3, 1.7, {0.8, 1.0}, 0.04, street::board());
  add_panel(scene, inside[1], 21.6, 1.7, {0.8, 1.0}, 0.04, street::board());
  add_panel(scene, inside[3], 24.5, 1.7, {0.9, 1.2}, 0.04, notice_board());
}

void add_area(Scene& scene, const Vector2d& low, const Vector2d& high, double piece, const Material& material) {
  const Vector2d size = high - low;
  const int columns = std::max(1, static_cast<int>(size.x() / piece)),
            rows = std::max(1, static_cast<int>(size.y() / piece));
  const double width = size.x() / columns, height = size.y() / rows;
  for (int column = 0; column < columns; ++column)
    for (int row = 0; row < rows; ++row)
      scene.add_quad({low.x() + (column + 0.5) * width, low.y() + (row + 0.5) * height, 0.0}, {width, 0, 0},
                     {0, -height, 0}, material);
}

void add_surroundings(Scene& scene) {
  add_area(scene, {-10.0, -46.0}, {92.0, outer_south}, 9.0, asphalt());
  add_area(scene, {outer_east, outer_south}, {92.0, 56.0}, 8.0, paving());
  add_area(scene, {court_west, court_south}, {court_east, court_north}, 8.0, paving());
  const double reach = 170.0, low = -4.0, high = 90.0, z = 0.5 * (low + high), height = high - low;
  const double x = 35.0, y = 5.0;
  scene.add_quad({x, y, -0.03}, {2 * reach, 0, 0}, {0, -2 * reach, 0}, street::grass());
  for (const double side : {-1.0, 1.0}) {
    scene.add_quad({x + side * reach, y, z}, {0, -side * 2 * reach, 0}, {0, 0, -height}, street::sky(-low));
    scene.add_quad({x, y + side * reach, z}, {side * 2 * reach, 0, 0}, {0, 0, -height}, street::sky(-low));
  }
  scene.add_quad({x, y, high}, {2 * reach, 0, 0}, {0, 2 * reach, 0}, street::sky_top());
}

/// Houses side by side between two points, 10 m deep, their fronts on the line and facing to the right of it.
void add_houses(Scene& scene, Random& random, const Wall& line, int front_face) {
  double distance = 0.0;
  while (distance < line.length() - 4.0) {
    const double width = std::min(random.uniform(9.0, 14.0), line.length() - distance);
    const int floors = 2 + static_cast<int>(random.below(2));
    const double height = 3.0 * floors + random.uniform(0.0, 0.9);
    const float tone = static_cast<float>(random.uniform(86.0, 146.0));
    const Vector3d a = line.at(distance, 0.0, 0.0), b = line.at(distance + width - 0.02, -10.0, height);
    const std::uint32_t house = add_block(scene, a.cwiseMin(b), a.cwiseMax(b), street::plain(90.0F));
    scene.paint_face(house, front_face, street::house_front(tone, floors));
    distance += width + (random.uniform() < 0.4 ? random.uniform(1.5, 4.0) : 0.0);
  }
}

void add_tree(Scene& scene, Random& random, const Vector2d& foot) {
  const double height = random.uniform(2.3, 3.1), size = random.uniform(1.1, 1.6);
  scene.add_cylinder({foot.x(), foot.y(), 0}, {foot.x(), foot.y(), height}, 0.16, street::bark());
  for (int i = 0; i < 3; ++i) {
    const double angle = random.uniform(0.0, 2.0 * std::numbers::pi), off = i == 0 ? 0.0 : 0.6 * size;
    scene.add_sphere(
        {foot.x() + off * std::cos(angle), foot.y() + off * std::sin(angle), height + 0.6 * size + 0.3 * i},
        size * (i == 0 ? 1.0 : 0.7), street::foliage(static_cast<float>(random.uniform(62.0, 96.0))));
  }
}

void add_street_lamp(Scene& scene, const Vector2d& foot, const Vector2d& arm) {
  const Vector3d base(foot.x(), foot.y(), 0), tip(foot.x() + arm.x(), foot.y() + arm.y(), 4.6);
  scene.add_cylinder(base, base + Vector3d(0, 0, 4.5), 0.06, street::pole(96.0F));
  scene.add_cylinder(base + Vector3d(0, 0, 4.5), tip, 0.04, street::pole(96.0F));
  scene.add_box(tip, {0.4, 0.4, 0.12}, street::street_lamp());
}

void add_lines_of_the_lot(Scene& scene) {
  for (const double middle : {-37.5, -26.2, -21.6})
    for (double x = 18.0; x <= 79.0; x += 3.0)
      scene.add_quad({x, middle, 0.005}, {0.1, 0, 0}, {0, -4.6, 0}, parking_line());
  for (double x = 36.0; x <= 72.0; x += 3.0)
    scene.add_quad({x, -9.6, 0.005}, {0.1, 0, 0}, {0, -4.6, 0}, parking_line());
}

void add_courtyard(Scene& scene, Random& random) {
  scene.add_cylinder({24.0, 17.8, 0}, {24.0, 17.8, 0.6}, 2.0, hall::concrete_pillar());
  scene.add_cylinder({24.0, 17.8, 0.6}, {24.0, 17.8, 2.2}, 0.35, hall::concrete_pillar());
  scene.add_sphere({24.0, 17.8, 2.6}, 0.6, hall::tank(120.0F));
  for (const Vector2d& foot : {Vector2d(9.5, 20.0),
                               {9.0, 30.5},
                               {20.0, 30.5},
                               {36.0, 29.0},
                               {46.0, 30.0},
                               {36.0, 20.0},
                               {47.0, 21.0},
                               {40.0, 8.2},
                               {26.0, 8.4},
                               {10.0, 8.6}})
    add_tree(scene, random, foot);
  for (const double x : {18.0, 34.0, 42.0}) add_block(scene, {x, 14.6, 0}, {x + 3.2, 15.6, 0.6}, hall::brick_wall());
  for (const double x : {19.6, 35.6, 43.6}) scene.add_sphere({x, 15.1, 0.9}, 0.6, street::foliage(80.0F));
}

}  // namespace

void add_grounds(Scene& scene, Random& random) {
  add_surroundings(scene);
  add_facades(scene);
  add_lines_of_the_lot(scene);
  add_houses(scene, random, {{94.0, -48.0}, {-12.0, -48.0}}, 2);
  add_houses(scene, random, {{96.0, 66.0}, {96.0, -46.0}}, 1);
  add_houses(scene, random, {{-14.0, -46.0}, {-14.0, 20.0}}, 0);
  for (double y = -40.0; y < 54.0; y += random.uniform(9.0, 13.0)) add_tree(scene, random, {90.5, y});
  for (double x = -4.0; x < 88.0; x += random.uniform(9.0, 13.0)) add_tree(scene, random, {x, -44.0});
  for (const double y : {-20.0, -2.0, 16.0, 34.0}) add_street_lamp(scene, {78.2, y}, {0.9, 0.0});
  for (const double x : {20.0, 40.0, 60.0, 76.0}) add_street_lamp(scene, {x, -23.9}, {0.0, x < 50.0 ? 0.8 : -0.8});
  for (const double y : {-30.0, -18.0}) add_block(scene, {8.0, y, 0}, {8.8, y + 9.0, 1.2}, street::hedge());
  add_block(scene, {86.5, -6.0, 0}, {87.1, 30.0, 1.1}, street::hedge());
  add_courtyard(scene, random);
}

}  // namespace rastro::campus
