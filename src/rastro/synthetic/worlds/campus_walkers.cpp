// SPDX-License-Identifier: Apache-2.0
// People on the campus. They walk to and fro beside the path of the camera, never across it.
#include <numbers>

#include "rastro/synthetic/worlds/campus_plan.h"
#include "rastro/synthetic/worlds/campus_scene.h"
#include "rastro/synthetic/worlds/people.h"

namespace rastro::campus {
namespace {

using Eigen::Vector3d;

struct Beat {
  Vector3d from, to;
  int people;
};

// In corridors 1 m beside the center line.
constexpr double side = 1.0, upstairs = storey_m;
const Beat beats[] = {
    {{6, side, 0}, {24, side, 0}, 1},
    {{4, -side, 0}, {22, -side, 0}, 1},
    {{-side, 5, 0}, {-side, 34, 0}, 1},
    {{side, 6, 0}, {side, 35, 0}, 1},
    {{5, 40 + side, 0}, {25, 40 + side, 0}, 1},
    {{8, side, upstairs}, {54, side, upstairs}, 1},
    {{6, -side, upstairs}, {52, -side, upstairs}, 2},
    {{side, 6, upstairs}, {side, 34, upstairs}, 1},
    {{-side, 6, upstairs}, {-side, 36, upstairs}, 1},
    {{6, 40 - side, upstairs}, {54, 40 - side, upstairs}, 2},
    {{8, 40 + side, upstairs}, {50, 40 + side, upstairs}, 1},
    {{34, side, 0}, {54, side, 0}, 1},
    {{17, 21.6, 0}, {48, 21.6, 0}, 1},
    {{18, 9.8, 0}, {50, 9.8, 0}, 2},
    {{11.4, 10, 0}, {11.4, 30, 0}, 1},
    {{33, 26, 0}, {50, 26, 0}, 1},
    {{20, -33.8, 0}, {78, -33.8, 0}, 2},
    {{20, -30.2, 0}, {78, -30.2, 0}, 2},
    {{34, -13.2, 0}, {74, -13.2, 0}, 2},
    {{16, -13.6, 0}, {25, -13.6, 0}, 1},
    {{80, -24, 0}, {80, 34, 0}, 2},
    {{84.2, -26, 0}, {84.2, 44, 0}, 2},
};

}  // namespace

void add_walkers(Scene& scene, Random& random) {
  for (const Beat& beat : beats)
    for (int i = 0; i < beat.people; ++i) {
      const double length = (beat.to - beat.from).norm();
      const Stroll stroll{beat.from, beat.to, random.uniform(0.75, 1.3), random.uniform(0.0, 2.0 * length)};
      add_person(
          scene, [stroll](double time_s) { return stroll.pose(time_s); }, random.uniform(0.0, 2.0 * std::numbers::pi),
          static_cast<float>(random.uniform(50.0, 180.0)));
    }
}

}  // namespace rastro::campus
