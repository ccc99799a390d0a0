// SPDX-License-Identifier: Apache-2.0
// People in the street of the loop that leads north. They walk up and down beside the camera's path, or across it where
// the camera is far.
#include "rastro/synthetic/worlds/loop_scene.h"
#include "rastro/synthetic/worlds/people.h"

namespace rastro::loop {
namespace {

using Eigen::Vector2d;

struct Walker {
  Vector2d from, to;
  double speed;    ///< m/s
  double start_m;  ///< Position on the walk there and back at time 0.
  float coat;
};

// The camera is at (22, y) with y from 2 to 12 between 12 and 20 s; nobody is ever closer to it than 0.6 m.
const Walker walkers[] = {
    {{23.1, 2.0}, {23.1, 17.5}, 1.1, 9.0, 60.0F},   {{20.8, 2.5}, {20.8, 12.0}, 1.0, 4.0, 150.0F},
    {{23.8, 1.0}, {23.8, 17.0}, 1.3, 24.0, 105.0F}, {{20.2, 3.0}, {20.2, 18.0}, 1.2, 20.0, 80.0F},
    {{23.4, 4.0}, {23.4, 18.0}, 0.9, 2.0, 175.0F},  {{21.0, 16.2}, {25.0, 16.2}, 0.8, 0.0, 120.0F},
    {{19.6, 17.2}, {24.6, 17.2}, 1.1, 3.0, 55.0F},  {{24.4, 5.0}, {24.4, 16.0}, 0.8, 14.0, 135.0F},
    {{20.6, 16.8}, {24.2, 15.8}, 0.9, 5.0, 95.0F},  {{19.5, 1.0}, {19.5, 12.6}, 1.2, 12.0, 165.0F},
    {{22.8, 15.4}, {22.8, 19.0}, 0.7, 1.0, 70.0F},  {{24.2, 17.9}, {20.0, 17.9}, 0.9, 2.0, 145.0F},
};

}  // namespace

void add_crowd(Scene& scene) {
  for (const Walker& walker : walkers) {
    const Stroll stroll{
        {walker.from.x(), walker.from.y(), 0.0}, {walker.to.x(), walker.to.y(), 0.0}, walker.speed, walker.start_m};
    add_person(
        scene, [stroll](double time_s) { return stroll.pose(time_s); }, walker.start_m, walker.coat);
  }
}

}  // namespace rastro::loop
