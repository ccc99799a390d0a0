// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "rastro/synthetic/worlds/street_drive.h"
#include "rastro/synthetic/worlds/street_materials.h"
#include "rastro/synthetic/worlds/street_scene.h"

namespace rastro::street {
namespace {

using Eigen::Vector3d;

/// A car that drives to the end of its street and, out of sight, starts again: `rounds` times in a lap of the drive.
struct Moving {
  int street;
  bool against;  ///< In the lane on the left of the street's direction.
  int rounds;
  double start_path;
};

// Chosen so that no car is in the way when the drive turns across its lane, as the world's test checks.
constexpr Moving cars[] = {
    {0, true, 2, 40.0},  {0, true, 2, 175.0},  {0, false, 2, 262.0}, {1, true, 3, 30.0},   {1, true, 3, 195.0},
    {1, true, 3, 215.0}, {1, false, 3, 105.0}, {2, true, 3, 45.0},   {2, true, 3, 160.0},  {2, false, 3, 20.0},
    {2, true, 3, 250.0}, {3, true, 2, 120.0},  {3, true, 2, 230.0},  {3, false, 2, 190.0},
};

}  // namespace

void add_car(Scene& scene, Random& random, const StreetLine& line, double distance, double left_m, bool against) {
  const float tone = random.uniform() < 0.5 ? static_cast<float>(random.uniform(24.0, 70.0))
                                            : static_cast<float>(random.uniform(105.0, 165.0));
  const double length = random.uniform(3.9, 4.7), width = random.uniform(1.62, 1.76), van = random.uniform() < 0.2;
  const double direction = against ? -1.0 : 1.0, roof = van > 0.5 ? 2.05 : random.uniform(1.42, 1.56);
  scene.add_box(line.at(distance, left_m, 0.59), line.size(length, width, 0.74), car_body(tone));
  const double cabin = van > 0.5 ? 0.86 * length : 0.56 * length;
  scene.add_box(line.at(distance - direction * 0.06 * length, left_m, 0.5 * (0.96 + roof)),
                line.size(cabin, width - 0.16, roof - 0.96), car_cabin(tone));
  scene.add_box(line.at(distance - direction * 0.06 * length, left_m, 1.05), line.size(cabin + 0.5, width - 0.1, 0.18),
                car_body(tone));
  for (const double along : {-0.31, 0.31})
    for (const double side : {-1.0, 1.0}) {
      const Vector3d hub = line.at(distance + along * length, left_m + side * (0.5 * width - 0.1), 0.31);
      scene.add_cylinder(hub - 0.11 * line.left3(), hub + 0.11 * line.left3(), 0.31, wheel());
    }
  scene.add_quad(line.at(distance, left_m, 0.006), -(width - 0.1) * line.left3(), -(length - 0.1) * line.along3(),
                 shadow());
}

void add_traffic(Scene& scene, Random& random) {
  const double lap_s = Drive().lap_s();
  for (const Moving& car : cars) {
    const StreetLine line = street_line(car.street);
    // It turns around behind the houses at the ends.
    const double reach = line.length + 24.0, speed = reach * car.rounds / lap_s;
    const Vector3d along = line.along3();
    scene.begin_moving([=](double time_s) {
      const double gone = car.start_path + 12.0 + (car.against ? -speed : speed) * time_s;
      const double distance = gone - reach * std::floor(gone / reach) - 12.0;
      return SE3(SO3(), distance * along);
    });
    add_car(scene, random, line, 0.0, car.against ? 0.5 * lane : -0.5 * lane, car.against);
  }
}

}  // namespace rastro::street
