// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/room_materials.h"
#include "rastro/synthetic/worlds/room_scenes.h"
#include "rastro/synthetic/worlds/room_things.h"
#include "rastro/synthetic/worlds/rooms.h"

namespace rastro::room {
namespace {

using Eigen::Vector3d;

constexpr double ahead = 2.3, behind = -2.0, left = 1.80, right = -1.90, ceiling = 2.5;
constexpr Color oak{190, 150, 104}, cream{222, 212, 190}, dark{86, 64, 48};

void add_shelves(Room& room, Random& random) {
  Scene& scene = *room.scene;
  const Vector3d high_low(2.05, 0.30, 1.42), high_high(ahead, 1.20, 1.58);
  add_block(scene, high_low, high_high, varnish(cream, 200.0));
  add_books(scene, random, {{2.12, 1.18, 1.58}, -Vector3d::UnitY(), Vector3d::UnitX(), 0.28, 0.24});
  add_plant(scene, random, {2.17, 0.42, 1.58}, 0.2);
  room.lengths.push_back(box_length("shelf height", high_low, high_high, 2, 1, -Vector3d::UnitX()));

  const Vector3d wide_low(2.06, -0.95, 1.15), wide_high(ahead, -0.20, 1.29);
  add_block(scene, wide_low, wide_high, varnish(cream, 200.0));
  add_books(scene, random, {{2.12, -0.34, 1.29}, -Vector3d::UnitY(), Vector3d::UnitX(), 0.26, 0.22});
  scene.add_sphere({2.18, -0.76, 1.29 + 0.08}, 0.08, globe());
  room.lengths.push_back(box_length("shelf width", wide_low, wide_high, 1, 2, -Vector3d::UnitX()));

  const Vector3d month_low(ahead - 0.006, -1.50, 1.22), month_high(ahead, -1.20, 1.64);
  const std::uint32_t month = add_block(scene, month_low, month_high, varnish({235, 232, 224}, 300.0));
  scene.paint_face(month, 1, calendar());
  room.lengths.push_back(box_length("calendar height", month_low, month_high, 2, 1, -Vector3d::UnitX()));
}

/// The pane itself is only a sheet of glass; its rim, legs and rails are solids.
void add_glass_table(Room& room, Random& random) {
  Scene& scene = *room.scene;
  const Vector3d low(0.25, -1.78, 0.72), high(1.10, -1.18, 0.728);
  const double rim = 0.006;
  add_block(scene, low, {low.x() + rim, high.y(), high.z()}, glass_edge());
  add_block(scene, {high.x() - rim, low.y(), low.z()}, high, glass_edge());
  add_block(scene, low, {high.x(), low.y() + rim, high.z()}, glass_edge());
  add_block(scene, {low.x(), high.y() - rim, low.z()}, high, glass_edge());
  scene.add_glass({0.5 * (low + high) + Vector3d(0, 0, 0.004), {high.x() - low.x(), 0, 0}, {0, low.y() - high.y(), 0}});
  for (const double x : {low.x() + 0.07, high.x() - 0.07})
    for (const double y : {low.y() + 0.07, high.y() - 0.07})
      scene.add_cylinder({x, y, 0.0}, {x, y, low.z()}, 0.018, metal({96, 98, 104}));
  for (const double y : {low.y() + 0.07, high.y() - 0.07})
    scene.add_cylinder({low.x() + 0.07, y, 0.66}, {high.x() - 0.07, y, 0.66}, 0.012, metal({96, 98, 104}));
  // On it and below it.
  scene.add_cylinder({0.78, -1.45, high.z()}, {0.78, -1.45, high.z() + 0.10}, 0.04, varnish({180, 60, 50}, 300.0));
  add_pile(scene, random, {0.50, -1.60, high.z()}, 3);
  add_block(scene, {0.45, -1.70, 0.0}, {0.85, -1.35, 0.26}, parcel());
  room.lengths.push_back(box_length("glass table width", low, high, 0, 1, Vector3d::UnitZ()));
}

void add_desk(Room& room, Random& random) {
  Scene& scene = *room.scene;
  add_table(scene, {1.62, -0.15, 0.0}, {ahead, 1.55, 0.74}, wood(oak));
  add_block(scene, {2.08, 0.35, 0.84}, {2.12, 0.90, 1.18}, varnish({36, 36, 40}));
  add_block(scene, {2.07, 0.37, 0.86}, {2.08, 0.88, 1.16}, screen());
  add_block(scene, {2.06, 0.56, 0.74}, {2.18, 0.69, 0.84}, varnish({36, 36, 40}));
  add_block(scene, {1.74, 0.42, 0.74}, {1.88, 0.84, 0.765}, keyboard());
  add_lamp(scene, {2.12, 1.36, 0.74}, 0.50);
  add_pile(scene, random, {1.88, 1.18, 0.74}, 5);
  add_books(scene, random, {{2.06, 0.26, 0.74}, -Vector3d::UnitY(), Vector3d::UnitX(), 0.34, 0.26});
  scene.add_cylinder({1.80, 0.24, 0.74}, {1.80, 0.24, 0.84}, 0.04, varnish({70, 120, 150}, 300.0));
  add_block(scene, {1.72, -0.06, 0.74}, {1.94, 0.12, 0.80}, parcel());
  add_block(scene, {1.85, 1.05, 0.0}, {2.25, 1.45, 0.36}, parcel());
  add_block(scene, {1.90, 0.05, 0.0}, {2.28, 0.35, 0.52}, varnish({58, 60, 66}, 200.0));
  add_chair(scene, {1.28, 0.80, 0.0}, 0.35, cloth({124, 62, 52}));
}

void add_bookcase_on_the_left(Room& room, Random& random) {
  Scene& scene = *room.scene;
  const double from = -0.75, to = 0.95, front = 1.52;
  for (const double x : {from, 0.5 * (from + to), to - board_m})
    add_block(scene, {x, front, 0.0}, {x + board_m, left, 2.1}, wood(oak));
  add_block(scene, {from, left - 0.01, 0.0}, {to, left, 2.1}, wood(oak));
  for (const double top : {0.08, 0.46, 0.82, 1.16, 1.50, 1.82, 2.1})
    add_block(scene, {from + board_m, front, top - board_m}, {to - board_m, left - 0.01, top}, wood(oak));
  for (const double top : {0.08, 0.46, 0.82, 1.16, 1.50, 1.82})
    for (const double x : {from + board_m, 0.5 * (from + to) + board_m})
      add_books(scene, random,
                {{x + 0.01, front + 0.03, top},
                 Vector3d::UnitX(),
                 Vector3d::UnitY(),
                 random.uniform(0.45, 0.77),
                 top > 1.8 ? 0.22 : 0.26});
}

void add_the_rest(Room& room, Random& random) {
  Scene& scene = *room.scene;
  // The wall behind.
  add_block(scene, {behind, -0.95, 0.0}, {behind + 0.04, -0.10, 2.05}, door({150, 110, 74}));
  const std::uint32_t cabinet = add_block(scene, {behind, 0.15, 0.0}, {-1.55, 1.30, 0.85}, wood(dark));
  scene.paint_face(cabinet, 0, door(dark));
  add_block(scene, {-1.95, 0.30, 0.85}, {-1.62, 0.74, 1.06}, varnish({196, 196, 190}, 200.0));
  scene.add_sphere({-1.76, 1.02, 1.05}, 0.15, globe());
  scene.add_cylinder({-1.76, 1.02, 0.85}, {-1.76, 1.02, 0.9}, 0.08, wood(dark));
  add_block(scene, {behind, 0.30, 1.35}, {behind + 0.02, 1.10, 1.95}, art({190, 180, 150}));
  add_block(scene, {behind + 0.05, -1.75, 0.0}, {-1.45, -1.25, 0.38}, parcel());
  add_block(scene, {behind + 0.08, -1.70, 0.38}, {-1.55, -1.30, 0.68}, parcel());
  // On the right.
  add_block(scene, {-0.9, right, 1.15}, {-0.1, right + 0.02, 1.75}, art({150, 160, 180}));
  add_block(scene, {0.35, right, 1.05}, {0.95, right + 0.02, 1.50}, art({200, 170, 140}));
  add_block(scene, {1.35, right, 1.10}, {1.75, right + 0.02, 1.60}, art({130, 150, 120}));
  add_block(scene, {ahead - 0.02, -1.05, 0.52}, {ahead, -0.45, 0.95}, art({170, 176, 190}));
  add_block(scene, {ahead - 0.02, -1.62, 1.80}, {ahead, -1.02, 2.2}, art({196, 160, 120}));
  add_block(scene, {ahead - 0.02, -0.05, 1.80}, {ahead, 0.22, 2.15}, art({160, 150, 170}));
  add_block(scene, {1.15, left - 0.02, 1.10}, {1.85, left, 1.65}, art({180, 160, 120}));
  add_block(scene, {-1.65, left - 0.02, 1.20}, {-1.0, left, 1.75}, art({120, 150, 160}));
  add_block(scene, {-1.1, right, 0.0}, {-0.1, -1.55, 0.80}, wood(oak));
  add_pile(scene, random, {-0.75, -1.70, 0.80}, 6);
  add_plant(scene, random, {-0.35, -1.72, 0.80}, 0.34);
  add_plant(scene, random, {1.75, -1.55, 0.0}, 0.75);
  add_block(scene, {1.45, -1.2, 0.0}, {1.75, -0.85, 0.32}, parcel());
  scene.add_cylinder({2.05, -0.55, 0.0}, {2.05, -0.55, 0.32}, 0.14, metal({110, 112, 118}));
}

Walk study_walk() {
  Walk walk;
  walk.keys = {
      {0.0, {0.00, 0.00, 1.40, 0, 8, 0}},       {3.0, {0.10, 0.35, 1.42, 5, 7, 1}},
      {6.0, {0.50, 0.45, 1.42, 2, 5, 0}},       {9.0, {0.60, -0.10, 1.40, -8, 6, -1}},
      {11.5, {0.55, -0.50, 1.38, -13, 8, 0}},   {14.0, {0.35, -0.35, 1.42, -35, 20, 1}},
      {16.5, {0.00, -0.35, 1.45, -60, 27, 0}},  {19.0, {-0.40, -0.30, 1.42, -42, 19, -1}},
      {22.0, {-0.60, 0.00, 1.40, -10, 8, 0}},   {24.5, {-0.50, 0.10, 1.38, 40, 8, 1}},
      {27.0, {-0.10, -0.10, 1.38, 95, 10, 0}},  {29.5, {0.50, -0.20, 1.40, 150, 12, 0}},
      {31.5, {0.60, -0.10, 1.40, 185, 12, -1}}, {33.5, {0.50, 0.00, 1.40, 140, 10, 0}},
      {36.0, {0.20, 0.10, 1.38, 70, 8, 0}},     {study_round_s, {0.00, 0.00, 1.40, 0, 8, 0}},
  };
  walk.swing_s = study_swing_s;
  return walk;
}

}  // namespace

Room build_study(std::uint64_t seed) {
  Room room;
  Random random(seed_for(seed, 32));
  const Material paint = wall_paint({150, 142, 122});
  add_shell(*room.scene,
            {{behind, right, 0.0}, {ahead, left, ceiling}, {paint, paint, paint, paint}, parquet({140, 98, 62})});
  room.scene->add_quad({0.35, -0.2, 0.004}, {2.0, 0, 0}, {0, -1.5, 0}, rug({120, 56, 50}, {204, 180, 130}));
  room.scene->add_cylinder({0.0, 0.2, ceiling - 0.07}, {0.0, 0.2, ceiling}, 0.2, lamp({244, 230, 196}));
  add_shelves(room, random);
  add_glass_table(room, random);
  add_desk(room, random);
  add_bookcase_on_the_left(room, random);
  add_the_rest(room, random);
  room.walk = study_walk();
  return room;
}

}  // namespace rastro::room
