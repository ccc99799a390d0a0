// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/people.h"

#include <cmath>
#include <numbers>

#include "rastro/synthetic/paint/details.h"
#include "rastro/synthetic/worlds/corridor_materials.h"

namespace rastro {
namespace {

using Eigen::Vector3d;

/// A coat with seams, buttons and its own pattern.
Material coat_material(float tone) {
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

Vector3d position_of(const Stroll& stroll, double time_s) {
  const double length = (stroll.to - stroll.from).norm(), gone = stroll.start_m + stroll.speed * time_s;
  const double distance = gone - 2.0 * length * std::floor(gone / (2.0 * length));
  return stroll.from + (distance < length ? distance : 2.0 * length - distance) / length * (stroll.to - stroll.from);
}

}  // namespace

SE3 Stroll::pose(double time_s) const {
  // Turns around within half a second.
  const Vector3d ahead = position_of(*this, time_s + 0.25) - position_of(*this, time_s - 0.25);
  const double heading = ahead.norm() > 1e-9 ? std::atan2(ahead.y(), ahead.x()) : 0.0;
  return {SO3::exp({0, 0, heading}), position_of(*this, time_s)};
}

void add_person(Scene& scene, const Motion& pose, double phase, float coat) {
  scene.begin_moving(pose);
  scene.add_box({0, 0, 1.12}, {0.28, 0.46, 0.64}, coat_material(coat));
  scene.add_sphere({0, 0, 1.60}, 0.13, corridor::skin());
  for (const double side : {-1.0, 1.0}) {
    scene.begin_moving([pose, phase, side](double time_s) {
      const double swing = 0.2 * std::sin(std::numbers::pi * 1.8 * time_s + phase);
      return pose(time_s) * SE3(SO3(), {side * swing, 0.0, 0.0});
    });
    scene.add_cylinder({0, side * 0.11, 0}, {0, side * 0.11, 0.82}, 0.08, corridor::cloth(0.5F * coat));
    scene.add_cylinder({0, side * 0.28, 0.82}, {0, side * 0.28, 1.4}, 0.055, corridor::cloth(0.9F * coat));
  }
}

}  // namespace rastro
