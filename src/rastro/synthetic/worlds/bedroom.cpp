// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/room_materials.h"
#include "rastro/synthetic/worlds/room_scenes.h"
#include "rastro/synthetic/worlds/room_things.h"
#include "rastro/synthetic/worlds/rooms.h"

namespace rastro::room {
namespace {

using Eigen::Vector3d;

constexpr double ahead = 2.3, behind = -1.9, left = 1.70, right = -1.75, ceiling = 2.4;
constexpr Color pine{206, 182, 140}, pale{226, 220, 206}, walnut{112, 78, 52};

void add_bed(Room& room) {
  const Vector3d low(-1.45, 0.75, 0.0), high(0.55, 1.70, 0.48);
  const std::uint32_t bed = add_block(*room.scene, low, high, checks({150, 60, 62}, {214, 190, 150}));
  room.scene->paint_face(bed, 4, checks({164, 70, 70}, {222, 204, 170}));
  // Clear of the edges of the measured length.
  add_block(*room.scene, {-1.34, 1.34, 0.48}, {-0.95, 1.68, 0.55}, cloth({228, 226, 218}));
  room.lengths.push_back(box_length("bed length", low, high, 0, 1, Vector3d::UnitZ()));
}

void add_shelf(Room& room, Random& random) {
  Scene& scene = *room.scene;
  const double front = 1.98, low = -0.80, high = 0.50;
  add_bookcase(scene, {{front, low, 0.0}, {ahead, high, 1.9}, {0.08, 0.46, 0.86, 1.28, 1.62, 1.9}, wood(pale)});
  for (const double z : {0.46, 0.86, 1.28})
    add_block(scene, {front, -0.17, z}, {ahead - 0.01, -0.145, z + 0.34}, wood(pale));
  const Vector3d box_low(2.08, 0.02, 0.86), box_high(2.28, 0.34, 1.11);
  add_block(scene, box_low, box_high, box_with_label({34, 66, 146}));
  room.lengths.push_back(box_length("blue box width", box_low, box_high, 1, 2, -Vector3d::UnitX()));
  room.lengths.push_back(box_length("blue box height", box_low, box_high, 2, 1, -Vector3d::UnitX()));
  add_books(scene, random, {{2.04, 0.46, 1.28}, -Vector3d::UnitY(), Vector3d::UnitX(), 0.42, 0.25});
  add_books(scene, random, {{2.04, -0.30, 0.86}, -Vector3d::UnitY(), Vector3d::UnitX(), 0.36, 0.26});
  add_books(scene, random, {{2.04, 0.30, 0.46}, -Vector3d::UnitY(), Vector3d::UnitX(), 0.30, 0.28});
  scene.add_sphere({2.14, -0.50, 1.28 + 0.09}, 0.09, globe());
  add_block(scene, {2.06, -0.72, 1.62}, {2.22, -0.40, 1.80}, varnish({60, 58, 60}, 200.0));
  add_plant(scene, random, {2.14, 0.25, 1.62}, 0.2);
  add_block(scene, {2.05, -0.70, 0.46}, {2.27, -0.30, 0.68}, parcel());
  add_block(scene, {2.04, -0.10, 0.08}, {2.27, 0.35, 0.30}, parcel());
}

void add_furniture(Room& room, Random& random) {
  Scene& scene = *room.scene;
  add_block(scene, {ahead - 0.06, 0.78, 0.85}, {ahead, 1.52, 2.15}, curtain({96, 112, 140}));
  add_block(scene, {0.95, 1.67, 1.2}, {1.55, 1.70, 1.65}, art({200, 190, 160}));
  add_block(scene, {-0.9, 1.67, 1.15}, {0.0, 1.70, 1.75}, art({150, 170, 180}));
  add_lamp(scene, {-1.68, 1.45, 0.0}, 1.45);
  // The wall behind: a wardrobe and a door.
  const std::uint32_t wardrobe = add_block(scene, {behind, right, 0.0}, {-1.35, -0.62, 2.0}, wood(pine));
  scene.paint_face(wardrobe, 0, door(pine));
  add_block(scene, {behind, -0.45, 0.0}, {behind + 0.04, 0.42, 2.05}, door({214, 208, 196}));
  add_block(scene, {behind, 0.62, 1.3}, {behind + 0.02, 1.0, 1.8}, art({190, 150, 120}));
  // On the right: a desk with a chair, and a chest.
  add_table(scene, {-0.95, right, 0.0}, {0.20, -1.22, 0.74}, wood(walnut));
  add_block(scene, {-0.72, right + 0.10, 0.82}, {-0.22, right + 0.14, 1.12}, varnish({40, 40, 44}));
  add_block(scene, {-0.70, right + 0.14, 0.83}, {-0.24, right + 0.15, 1.11}, screen());
  add_block(scene, {-0.52, right + 0.06, 0.74}, {-0.42, right + 0.18, 0.82}, varnish({40, 40, 44}));
  add_block(scene, {-0.65, -1.40, 0.74}, {-0.25, -1.27, 0.765}, keyboard());
  add_pile(scene, random, {0.02, -1.48, 0.74}, 4);
  add_chair(scene, {-0.35, -0.95, 0.0}, -1.35, cloth({70, 84, 110}));
  const std::uint32_t chest = add_block(scene, {0.55, right, 0.0}, {1.45, -1.42, 0.62}, wood(pine));
  scene.paint_face(chest, 2, door(pine));
  add_plant(scene, random, {1.25, -1.58, 0.62}, 0.32);
  add_block(scene, {0.66, -1.68, 0.62}, {0.95, -1.48, 0.78}, parcel());
  add_block(scene, {0.45, right, 1.15}, {1.25, right + 0.02, 1.75}, art({170, 176, 150}));
}

Walk bedroom_walk() {
  Walk walk;
  walk.keys = {
      {0.0, {0.00, 0.00, 1.35, 0, 9, 0}},        {3.0, {0.15, -0.35, 1.38, 6, 11, 1}},
      {6.0, {0.45, -0.70, 1.32, 20, 13, 0}},     {9.0, {0.85, -0.40, 1.26, 7, 10, -1}},
      {11.5, {0.75, 0.15, 1.24, -6, 11, 0}},     {14.0, {0.20, 0.10, 1.34, -4, 9, 1}},
      {17.0, {-0.10, 0.00, 1.38, -8, 9, 0}},     {19.5, {0.20, -0.30, 1.36, -50, 14, -1}},
      {22.0, {0.70, -0.50, 1.36, -110, 18, 0}},  {24.5, {1.10, -0.70, 1.38, -170, 15, 1}},
      {27.0, {1.25, -0.95, 1.42, -222, 20, 0}},  {29.0, {1.00, -1.10, 1.42, -228, 21, 0}},
      {31.0, {0.65, -0.90, 1.40, -198, 16, -1}}, {33.5, {0.40, -0.40, 1.38, -110, 13, 0}},
      {36.5, {0.15, -0.10, 1.36, -35, 10, 0}},   {bedroom_round_s, {0.00, 0.00, 1.35, 0, 9, 0}},
  };
  walk.swing_s = bedroom_swing_s;
  return walk;
}

}  // namespace

Room build_bedroom(std::uint64_t seed) {
  Room room;
  Random random(seed_for(seed, 31));
  const Material paper = wallpaper({206, 200, 182}, {150, 158, 150}), paint = wall_paint({198, 196, 184});
  add_shell(*room.scene,
            {{behind, right, 0.0}, {ahead, left, ceiling}, {paper, paper, paint, paint}, parquet({168, 126, 84})});
  room.scene->add_quad({0.55, -0.25, 0.004}, {1.7, 0, 0}, {0, -1.2, 0}, rug({84, 92, 120}, {206, 190, 150}));
  room.scene->add_cylinder({0.2, 0.0, ceiling - 0.08}, {0.2, 0.0, ceiling}, 0.22, lamp({252, 246, 226}));
  add_shelf(room, random);
  add_bed(room);
  add_furniture(room, random);
  room.walk = bedroom_walk();
  return room;
}

}  // namespace rastro::room
