// SPDX-License-Identifier: Apache-2.0
// People in the street of the loop that leads north. They walk up and down beside the camera's path, or across it where
// the camera is far.
#include <cmath>
#include <numbers>

#include "rastro/synthetic/paint/details.h"
#include "rastro/synthetic/worlds/corridor_materials.h"
#include "rastro/synthetic/worlds/loop_scene.h"

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

/// A coat with seams, buttons and its own pattern.
Material coat(float tone) {
  return {[tone](Canvas& canvas, Random& random) {
            const double width = canvas.width(), height = canvas.height();
            canvas.fill(tone);
            const double pitch = random.uniform(0.06, 0.16);
            const float other = tone + (tone > 110.0F ? -50.0F : 60.0F);
            for (double y = 0.0; y < height; y += pitch) canvas.rectangle(0, y, width, y + 0.3 * pitch, other, 0.7F);
            for (double x = 0.5 * pitch; x < width; x += 1.7 * pitch)
              canvas.rectangle(x, 0, x + 0.2 * pitch, height, other, 0.6F);
            for (int i = 0; i < 6; ++i) {
              const double x = random.uniform(0.0, 0.8 * width), y = random.uniform(0.0, 0.8 * height);
              canvas.rectangle(x, y, x + random.uniform(0.05, 0.16), y + random.uniform(0.05, 0.2),
                               static_cast<float>(random.uniform(20, 235)));
            }
            paint::label(canvas, random, {0.3 * width, 0.2 * height, 0.6 * width, 0.45 * height});
            canvas.add_noise(random, 0.2, 10.0F, 0.85F);
          },
          140.0};
}

Vector2d position_of(const Walker& walker, double time_s) {
  const double length = (walker.to - walker.from).norm(), gone = walker.start_m + walker.speed * time_s;
  const double distance = gone - 2.0 * length * std::floor(gone / (2.0 * length));
  return walker.from + (distance < length ? distance : 2.0 * length - distance) / length * (walker.to - walker.from);
}

SE3 pose_of(const Walker& walker, double time_s) {
  const Vector2d here = position_of(walker, time_s);
  // Turns around within half a second.
  const Vector2d ahead = position_of(walker, time_s + 0.25) - position_of(walker, time_s - 0.25);
  const double heading = ahead.norm() > 1e-9 ? std::atan2(ahead.y(), ahead.x()) : 0.0;
  return {SO3::exp({0, 0, heading}), {here.x(), here.y(), 0.0}};
}

}  // namespace

void add_crowd(Scene& scene) {
  for (const Walker& walker : walkers) {
    scene.begin_moving([walker](double time_s) { return pose_of(walker, time_s); });
    scene.add_box({0, 0, 1.12}, {0.28, 0.46, 0.64}, coat(walker.coat));
    scene.add_sphere({0, 0, 1.60}, 0.13, corridor::skin());
    for (const double side : {-1.0, 1.0}) {
      scene.begin_moving([walker, side](double time_s) {
        const double swing = 0.2 * std::sin(std::numbers::pi * 1.8 * time_s + walker.start_m);
        return pose_of(walker, time_s) * SE3(SO3(), {side * swing, 0.0, 0.0});
      });
      scene.add_cylinder({0, side * 0.11, 0}, {0, side * 0.11, 0.82}, 0.08, corridor::cloth(0.5F * walker.coat));
      scene.add_cylinder({0, side * 0.28, 0.82}, {0, side * 0.28, 1.4}, 0.055, corridor::cloth(0.9F * walker.coat));
    }
  }
}

}  // namespace rastro::loop
