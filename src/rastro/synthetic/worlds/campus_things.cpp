// SPDX-License-Identifier: Apache-2.0
// Objects that people leave elsewhere from lap to lap: furniture, bicycles, parked cars.
#include <array>
#include <cmath>
#include <numbers>

#include "rastro/synthetic/worlds/campus_plan.h"
#include "rastro/synthetic/worlds/campus_scene.h"
#include "rastro/synthetic/worlds/campus_walk.h"
#include "rastro/synthetic/worlds/corridor_materials.h"
#include "rastro/synthetic/worlds/hall_materials.h"
#include "rastro/synthetic/worlds/street_materials.h"
#include "rastro/synthetic/worlds/street_scene.h"

namespace rastro::campus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double share_that_changes = 0.36;

float tone_of(Random& random, double low = 60.0, double high = 180.0) {
  return static_cast<float>(random.uniform(low, high));
}

/// Where something stands against a wall: `at` on the floor beside it, `out` away from it.
struct Spot {
  Vector3d at;
  Vector2d along, out;

  /// A box of `size` (along, out, up) whose back is `off` from the wall, `aside` along it.
  std::uint32_t box(Scene& scene, double aside, double off, double z, const Vector3d& size,
                    const Material& material) const {
    const Vector2d middle = aside * along + (off + 0.5 * size.y()) * out;
    const Vector2d plan = size.x() * along.cwiseAbs() + size.y() * out.cwiseAbs();
    return scene.add_box(at + Vector3d(middle.x(), middle.y(), z + 0.5 * size.z()), {plan.x(), plan.y(), size.z()},
                         material);
  }
};

void add_bench(Scene& scene, Random& random, const Spot& spot) {
  const float tone = tone_of(random, 90, 160);
  spot.box(scene, 0.0, 0.04, 0.38, {1.5, 0.36, 0.07}, corridor::wood(tone));
  for (const double side : {-0.6, 0.6}) spot.box(scene, side, 0.08, 0.0, {0.08, 0.28, 0.38}, corridor::metal(70.0F));
  if (random.uniform() < 0.6)
    spot.box(scene, random.uniform(-0.4, 0.4), 0.1, 0.45, {0.34, 0.22, 0.3}, hall::cardboard());
}

void add_cupboard(Scene& scene, Random& random, const Spot& spot) {
  const double height = random.uniform(0.9, 1.9);
  spot.box(scene, 0.0, 0.02, 0.0, {random.uniform(0.7, 1.1), 0.36, height}, hall::cabinet(tone_of(random)));
  if (height < 1.3) spot.box(scene, 0.1, 0.08, height, {0.4, 0.24, 0.26}, hall::cardboard());
}

void add_chairs(Scene& scene, Random& random, const Spot& spot) {
  const float tone = tone_of(random, 50, 150);
  for (const double aside : {-0.5, 0.1}) {
    spot.box(scene, aside, 0.04, 0.42, {0.46, 0.34, 0.05}, corridor::cloth(tone));
    spot.box(scene, aside, 0.02, 0.47, {0.46, 0.05, 0.42}, corridor::cloth(tone));
    spot.box(scene, aside, 0.12, 0.0, {0.4, 0.2, 0.42}, corridor::metal(60.0F));
  }
}

void add_plant(Scene& scene, Random& random, const Spot& spot) {
  const Vector3d foot = spot.at + 0.22 * Vector3d(spot.out.x(), spot.out.y(), 0.0);
  scene.add_cylinder(foot, foot + Vector3d(0, 0, 0.4), 0.17, hall::drum(tone_of(random)));
  scene.add_sphere(foot + Vector3d(0, 0, 0.72), 0.2, corridor::leaves());
  scene.add_sphere(foot + Vector3d(0, 0, 1.0), 0.16, corridor::leaves());
}

void add_copier(Scene& scene, Random& random, const Spot& spot) {
  spot.box(scene, 0.0, 0.02, 0.0, {0.62, 0.38, 0.95}, hall::machine(tone_of(random, 120, 190), 130.0, 0.2));
  spot.box(scene, 0.5, 0.05, 0.0, {0.3, 0.3, 0.62}, corridor::metal(110.0F));
}

void add_parcels(Scene& scene, Random& random, const Spot& spot) {
  double z = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double size = random.uniform(0.24, 0.36);
    spot.box(scene, random.uniform(-0.05, 0.05), 0.02, z, {1.3 * size, size, size}, hall::cardboard());
    z += size;
  }
  spot.box(scene, 0.55, 0.03, 0.0, {0.3, 0.3, 0.45}, hall::wooden_crate());
}

void add_furniture(LapThings& things) {
  using Add = void (*)(Scene&, Random&, const Spot&);
  constexpr Add kinds[] = {add_bench, add_cupboard, add_chairs, add_plant, add_copier, add_parcels};
  for (const int storey : {0, 1})
    for (const Wall& wall : corridor_walls(storey))
      for (double bay = 0.0; bay + 4.0 < wall.length(); bay += bay_m) {
        if (things.random().uniform() > 0.42) continue;
        // Between the doors, and clear of the corners.
        const double distance = std::max(2.8, bay + things.random().uniform(-0.6, 0.6));
        if (distance > wall.length() - 2.8 || !wall.closed(distance - 1.4, distance + 1.4)) continue;
        const Spot spot{wall.at(distance, 0.0, wall.low), wall.along(), wall.out()};
        const Add add = kinds[things.random().below(std::size(kinds))];
        things.add(spot.at, {spot.along.x(), spot.along.y(), 0.0},
                   [add, spot](Scene& scene, Random& random) { add(scene, random, spot); });
      }
}

void add_bicycle(Scene& scene, Random& random, const Vector3d& at) {
  const Vector3d along(1.0, 0.0, 0.0), axle = at + Vector3d(0, 0, 0.34);
  const float tone = tone_of(random);
  for (const double side : {-0.52, 0.52})
    scene.add_cylinder(axle + side * along + Vector3d(0, -0.025, 0), axle + side * along + Vector3d(0, 0.025, 0), 0.34,
                       street::wheel());
  scene.add_box(at + Vector3d(0, 0, 0.62), {0.9, 0.05, 0.1}, street::pole(tone));
  scene.add_box(at + Vector3d(-0.2, 0, 0.85), {0.25, 0.14, 0.08}, corridor::cloth(40.0F));
  scene.add_box(at + Vector3d(0.42, 0, 0.95), {0.06, 0.5, 0.06}, street::pole(80.0F));
  if (random.uniform() < 0.5) scene.add_box(at + Vector3d(0.62, 0, 0.8), {0.3, 0.3, 0.24}, hall::wooden_crate());
}

void add_table(Scene& scene, Random& random, const Vector3d& at) {
  scene.add_cylinder(at, at + Vector3d(0, 0, 0.7), 0.06, street::pole(90.0F));
  scene.add_cylinder(at + Vector3d(0, 0, 0.7), at + Vector3d(0, 0, 0.75), 0.5, hall::drum(tone_of(random)));
  for (const double side : {-0.8, 0.8}) {
    scene.add_box(at + Vector3d(side, 0.1, 0.22), {0.4, 0.4, 0.44}, corridor::wood(tone_of(random)),
                  random.uniform(-0.4, 0.4));
    scene.add_box(at + Vector3d(1.2 * side, 0.1, 0.65), {0.05, 0.4, 0.45}, corridor::wood(tone_of(random)));
  }
}

void add_yard_things(LapThings& things) {
  const auto bicycle = [](const Vector3d& at) {
    return [at](Scene& scene, Random& random) { add_bicycle(scene, random, at); };
  };
  const auto table = [](const Vector3d& at) {
    return [at](Scene& scene, Random& random) { add_table(scene, random, at); };
  };
  for (double y = 7.0; y < 10.0; y += 0.8)
    for (const double x : {15.5, 33.0}) things.add({x, y, 0}, {1, 0, 0}, bicycle({x, y, 0}));
  for (const Vector2d& at : {Vector2d(19.0, 20.5),
                             {29.0, 15.4},
                             {33.5, 24.0},
                             {38.0, 24.5},
                             {43.0, 18.0},
                             {17.5, 27.0},
                             {25.0, 27.0},
                             {49.5, 16.0}})
    things.add({at.x(), at.y(), 0}, {1, 0, 0}, table({at.x(), at.y(), 0}));
  for (const double y : {4.0, 10.0, 24.0, 30.0})
    things.add({78.0, y, 0}, {0, 1, 0}, [y](Scene& scene, Random& random) {
      add_bench(scene, random, {{outer_east, y, 0}, {0.0, 1.0}, {1.0, 0.0}});
    });
  for (const double y : {14.0, 20.5, 27.5}) things.add({77.0, y, 0}, {0, 1, 0}, bicycle({77.4, y, 0}));
}

LapThings::Build car_at(const Vector3d& at, bool north_south, bool against) {
  return [=](Scene& scene, Random& random) {
    const Vector2d along = north_south ? Vector2d(0.0, 1.0) : Vector2d(1.0, 0.0);
    street::add_car(scene, random, {{at.x(), at.y()}, along}, 0.0, 0.0, against);
  };
}

/// A slot of the parking lot: two of five are free; in a third of the others another car, or none, stands in each lap.
void add_slot(LapThings& things, const Vector3d& at, bool north_south) {
  Random& random = things.random();
  if (random.uniform() < 0.4) return;
  const auto car = [&] { return car_at(at, north_south, random.uniform() < 0.5); };
  if (random.uniform() > share_that_changes) return things.replace(at, {car()});
  std::vector<LapThings::Build> builds;
  for (int lap = 0; lap < laps; ++lap) builds.push_back(random.uniform() < 0.4 ? LapThings::Build() : car());
  things.replace(at, builds);
}

void add_cars(LapThings& things) {
  for (const double y : {-37.5, -26.2, -21.6})
    for (double x = 19.5; x < 78.0; x += 3.0) add_slot(things, {x, y, 0.0}, true);
  for (double x = 37.5; x < 72.0; x += 3.0) add_slot(things, {x, -9.6, 0.0}, true);
  for (double y = -36.0; y < 40.0; y += 6.5) add_slot(things, {88.6, y, 0.0}, true);
}

}  // namespace

void LapThings::add(const Vector3d& position, const Vector3d& free, const Build& build) {
  Moving moving{build, random_.next(), tour().nearest(position), {}};
  const bool changes = random_.uniform() < share_that_changes;
  for (int lap = 0; lap < laps; ++lap) {
    const double shift = random_.uniform(0.7, 1.8) * (random_.uniform() < 0.5 ? -1.0 : 1.0);
    const bool gone = random_.uniform() < 0.4;
    moving.offsets.push_back(lap == 0 && !gone ? Vector3d(Vector3d::Zero()) : gone ? gone_m : Vector3d(shift * free));
  }
  if (changes) {
    moving_.push_back(std::move(moving));
  } else {
    Random own(moving.seed);
    build(scene_, own);
  }
}

void LapThings::replace(const Vector3d& position, const std::vector<Build>& builds) {
  if (builds.size() == 1) {
    Random own(random_.next());
    return builds[0](scene_, own);
  }
  for (std::size_t lap = 0; lap < builds.size(); ++lap) {
    if (!builds[lap]) continue;
    std::vector<Vector3d> offsets(builds.size(), gone_m);
    offsets[lap].setZero();
    moving_.push_back({builds[lap], random_.next(), tour().nearest(position), offsets});
  }
}

void LapThings::add_moving() {
  for (const Moving& moving : moving_) {
    scene_.begin_moving([offsets = moving.offsets, at_m = moving.at_m](double time_s) {
      return SE3(SO3(), offsets[static_cast<std::size_t>(tour().visit(time_s, at_m))]);
    });
    Random own(moving.seed);
    moving.build(scene_, own);
  }
}

void add_things(LapThings& things) {
  add_furniture(things);
  add_yard_things(things);
  add_cars(things);
}

}  // namespace rastro::campus
