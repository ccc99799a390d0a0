// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/hall_scene.h"

#include <Eigen/Core>

#include "rastro/synthetic/worlds/hall_materials.h"

namespace rastro::hall {
namespace {

using Eigen::Vector3d;

constexpr double x_back = -9.5, x_front = 24.0, y_right = -11.0, y_left = 11.0, roof = 7.5;

/// Furnishes the hall. The random generator varies tones, positions and sizes, never what the first 120 frames rely on.
class Furnisher {
 public:
  Furnisher(Scene& scene, std::uint64_t seed) : scene_(scene), random_(seed) {}

  void shell() {
    const double length = x_front - x_back, width = y_left - y_right, middle = 0.5 * (x_front + x_back);
    scene_.add_quad({middle, 0, 0}, {length, 0, 0}, {0, -width, 0}, concrete_floor());
    scene_.add_quad({middle, 0, roof}, {length, 0, 0}, {0, width, 0}, ceiling_sheet());
    scene_.add_quad({x_front, 0, 0.5 * roof}, {0, -width, 0}, {0, 0, -roof}, brick_wall());
    scene_.add_quad({x_back, 0, 0.5 * roof}, {0, width, 0}, {0, 0, -roof}, brick_wall());
    scene_.add_quad({middle, y_left, 0.5 * roof}, {length, 0, 0}, {0, 0, -roof}, brick_wall());
    scene_.add_quad({middle, y_right, 0.5 * roof}, {-length, 0, 0}, {0, 0, -roof}, brick_wall());
    windows_and_gates();
  }

  /// The occluders: the press's head, hung from the roof, and the pillar at its right.
  void press() {
    scene_.add_box({0.72, 0.05, 2.26}, {0.12, 2.4, 1.1}, machine(122, 330, 0.24));
    scene_.add_box({1.00, 0.05, 3.02}, {0.60, 2.2, 0.5}, machine(96, 170));
    for (const double y : {-0.7, 0.8}) scene_.add_cylinder({1.0, y, 3.27}, {1.0, y, roof - 0.01}, 0.13, pipe(150));
    scene_.add_box({1.00, -1.78, 0.5 * roof}, {0.38, 0.38, roof - 0.01}, concrete_pillar());
  }

  void machines_ahead() {
    block({3.5, 1.75, 0.0}, {1.3, 1.3, 1.15}, 150);
    scene_.add_box({3.6, 1.9, 1.55}, {0.5, 0.6, 0.8}, cabinet(100), 0.3);
    block({5.0, -1.15, 0.0}, {1.5, 1.3, 2.5}, 92);
    scene_.add_box({4.6, -2.3, 0.55}, {1.0, 0.8, 1.1}, machine(165), -0.2);
    barrel({4.6, -2.3, 1.1}, 0.24, 175);
    block({6.6, 2.9, 0.0}, {1.8, 2.2, 3.3}, 135);
    scene_.add_box({6.1, 0.55, 1.6}, {0.9, 0.9, 3.2}, cabinet(155), 0.12);
    block({8.6, -0.6, 0.0}, {1.6, 2.0, 4.1}, 110);
    scene_.add_cylinder({6.6, -4.0, 0.0}, {6.6, -4.0, 3.1}, 0.95, tank(168));
    scene_.add_sphere({6.6, -4.0, 3.05}, 0.95, tank(160));
    scene_.add_cylinder({8.6, -5.6, 0.0}, {8.6, -5.6, 4.3}, 0.8, tank(98));
    scene_.add_cylinder({5.0, -1.15, 2.2}, {8.6, -0.6, 3.4}, 0.13, pipe(185));
    scene_.add_cylinder({6.6, 2.9, 3.0}, {6.6, -4.0, 3.6}, 0.15, pipe(120));
    scene_.add_cylinder({5.2, -1.9, 2.3}, {6.6, -3.4, 2.3}, 0.10, pipe(200));
  }

  void near_floor() {
    scene_.add_box({2.75, 0.55, 0.30}, {0.6, 0.75, 0.6}, wooden_crate(), 0.35);
    scene_.add_box({2.85, 0.60, 0.72}, {0.35, 0.45, 0.24}, cardboard(), 0.6);
    barrel({3.0, -0.75, 0.0}, 0.29, 70);
    barrel({3.5, -0.25, 0.0}, 0.29, 180);
    scene_.add_box({2.5, -1.7, 0.36}, {0.7, 0.7, 0.72}, wooden_crate(), -0.25);
    scene_.add_box({2.9, -3.2, 0.5}, {0.8, 1.0, 1.0}, machine(140), 0.2);
    barrel({2.6, -4.4, 0.0}, 0.29, 150);
    scene_.add_box({3.0, 3.3, 0.4}, {0.8, 1.0, 0.8}, wooden_crate(), 0.1);
  }

  /// Racks of boxes along both sides, facing the aisle.
  void racks() {
    rack({3.4, -6.3}, 2.4, 3);
    rack({4.4, 5.9}, 3.2, 3);
    rack({11.5, 5.6}, 3.0, 4);
    rack({-8.6, -3.6}, 4.0, 3);
    rack({-8.6, 4.2}, 3.4, 3);
  }

  void side_rows() {
    for (double x = -7.0; x < 22.0; x += random_.uniform(2.0, 2.8)) {
      for (const double side : {-1.0, 1.0}) {
        const Vector3d size(random_.uniform(1.0, 1.7), random_.uniform(0.9, 1.5), random_.uniform(1.0, 3.4));
        const Vector3d foot(x, side * random_.uniform(8.6, 9.3), 0.0);
        const float tone = some_tone();
        if (random_.uniform() < 0.25)
          scene_.add_cylinder(foot, foot + Vector3d(0, 0, size.z()), 0.5 * size.y(), tank(tone));
        else if (random_.uniform() < 0.35)
          scene_.add_box(foot + Vector3d(0, 0, 0.5 * size.z()), size, cabinet(tone));
        else
          block(foot, size, tone);
      }
    }
  }

  void far_end() {
    for (double x = 11.0; x < 21.0; x += 3.1)
      for (double y = -6.0; y < 7.0; y += random_.uniform(2.6, 3.6)) {
        const Vector3d size(random_.uniform(1.0, 1.8), random_.uniform(1.0, 1.9), random_.uniform(1.2, 4.2));
        block({x + random_.uniform(-0.5, 0.5), y, 0.0}, size, some_tone(), random_.uniform(-0.2, 0.2));
      }
    scene_.add_box({-8.6, 0.3, 1.0}, {0.9, 2.2, 2.0}, cabinet(140));
    scene_.add_box({-8.4, 7.6, 1.3}, {1.2, 1.6, 2.6}, machine(110));
    scene_.add_box({-8.4, -7.4, 1.1}, {1.2, 1.8, 2.2}, machine(160));
  }

  void overhead() {
    for (double x = -7.4; x < x_front; x += 3.9) {
      scene_.add_box({x, 0, 6.55}, {0.22, y_left - y_right, 0.36}, steel_beam(86, 60));
      for (double y = -7.5; y < 8.0; y += 5.0) {
        scene_.add_box({x + 1.9, y, 6.62}, {0.35, 1.5, 0.10}, steel_beam(120, 60));
        scene_.add_quad({x + 1.9, y, 6.56}, {0.28, 0, 0}, {0, 1.4, 0}, lamp());
      }
    }
    for (const double y : {-6.2, 6.2})
      scene_.add_box({7.2, y, 5.75}, {x_front - x_back - 0.4, 0.30, 0.34}, steel_beam(104, 80));
    scene_.add_box({10.4, 0, 6.05}, {0.55, 12.6, 0.55}, steel_beam(175, 110));
    scene_.add_box({10.3, -2.2, 5.45}, {0.9, 1.1, 0.6}, machine(150));
    scene_.add_cylinder({10.3, -2.2, 3.7}, {10.3, -2.2, 5.2}, 0.04, pipe(60));
    scene_.add_box({10.3, -2.2, 3.5}, {0.3, 0.35, 0.5}, steel_beam(190, 150));
    for (const double y : {-10.8, 10.8})
      for (const double z : {3.15, 3.5})
        scene_.add_cylinder({x_back + 0.3, y, z}, {x_front - 0.3, y, z}, 0.11, pipe(some_tone()));
    for (const double z : {3.2, 3.75})
      scene_.add_cylinder({x_front - 0.25, -10.5, z}, {x_front - 0.25, 10.5, z}, 0.14, pipe(some_tone()));
  }

  void ladders() {
    ladder({5.74, 2.3}, 3.3);
    ladder({7.79, -0.9}, 4.1);
  }

 private:
  float some_tone() { return static_cast<float>(random_.uniform(72.0, 178.0)); }

  /// A machine: a body with a plinth, a box on top and something at its front.
  void block(const Vector3d& foot, const Vector3d& size, float tone, double yaw = 0.0) {
    scene_.add_box(foot + Vector3d(0, 0, 0.07), {size.x() + 0.12, size.y() + 0.12, 0.14}, steel_beam(60, 60), yaw);
    scene_.add_box(foot + Vector3d(0, 0, 0.14 + 0.5 * (size.z() - 0.14)), {size.x(), size.y(), size.z() - 0.14},
                   machine(tone), yaw);
    if (random_.uniform() < 0.6) {
      const Vector3d top(0.4 * size.x(), 0.5 * size.y(), random_.uniform(0.25, 0.6));
      scene_.add_box(foot + Vector3d(0, random_.uniform(-0.2, 0.2) * size.y(), size.z() + 0.5 * top.z()), top,
                     machine(tone > 125.0F ? 85.0F : 165.0F), yaw);
    }
    if (yaw == 0.0 && random_.uniform() < 0.8) {
      const double side = random_.uniform(-0.25, 0.25) * size.y(), height = random_.uniform(0.45, 0.7) * size.z();
      scene_.add_box(foot + Vector3d(-0.5 * size.x() - 0.09, side, height),
                     {0.18, random_.uniform(0.3, 0.5), random_.uniform(0.35, 0.6)},
                     cabinet(tone > 125.0F ? 95.0F : 185.0F));
    }
  }

  void barrel(const Vector3d& foot, double radius, float tone) {
    const std::uint32_t barrel = scene_.add_cylinder(foot, foot + Vector3d(0, 0, 3.03 * radius), radius, drum(tone));
    scene_.paint_face(barrel, 1, lid(tone));
  }

  void rack(const Eigen::Vector2d& foot, double width, int shelves) {
    const double depth = 0.9, pitch = 0.95;
    for (const double y : {-0.5 * width, 0.5 * width})
      for (const double x : {0.0, depth})
        scene_.add_box({foot.x() + x, foot.y() + y, 0.5 * shelves * pitch + 0.15}, {0.09, 0.09, shelves * pitch + 0.3},
                       steel_beam(70, 120));
    for (int shelf = 0; shelf < shelves; ++shelf) {
      const double z = 0.2 + shelf * pitch;
      scene_.add_box({foot.x() + 0.5 * depth, foot.y(), z}, {depth, width - 0.1, 0.09}, steel_beam(165, 120));
      for (double y = -0.5 * width + 0.1; y < 0.5 * width - 0.5;) {
        const Vector3d size(random_.uniform(0.4, 0.75), random_.uniform(0.35, 0.7), random_.uniform(0.3, 0.72));
        if (y + size.y() > 0.5 * width - 0.05) break;
        scene_.add_box(
            {foot.x() + random_.uniform(0.38, 0.5), foot.y() + y + 0.5 * size.y(), z + 0.05 + 0.5 * size.z()}, size,
            random_.uniform() < 0.3 ? wooden_crate() : cardboard());
        y += size.y() + random_.uniform(0.03, 0.25);
      }
    }
  }

  void ladder(const Eigen::Vector2d& foot, double height) {
    for (const double y : {-0.22, 0.22})
      scene_.add_box({foot.x() - 0.12, foot.y() + y, 0.5 * height}, {0.05, 0.05, height}, steel_beam(205, 60));
    for (double z = 0.3; z < height - 0.1; z += 0.31)
      scene_.add_box({foot.x() - 0.12, foot.y(), z}, {0.04, 0.42, 0.04}, steel_beam(190, 60));
  }

  void windows_and_gates() {
    for (double y = -9.0; y < 9.5; y += 3.0) {
      scene_.add_quad({x_front - 0.03, y, 5.2}, {0, -2.2, 0}, {0, 0, -1.7}, window());
      scene_.add_quad({x_back + 0.03, y, 5.2}, {0, 2.2, 0}, {0, 0, -1.7}, window());
    }
    for (double x = -7.5; x < x_front - 1.5; x += 3.2) {
      scene_.add_quad({x, y_left - 0.03, 5.2}, {2.3, 0, 0}, {0, 0, -1.7}, window());
      scene_.add_quad({x, y_right + 0.03, 5.2}, {-2.3, 0, 0}, {0, 0, -1.7}, window());
      scene_.add_quad({x + 1.6, y_left - 0.02, 2.4}, {0.7, 0, 0}, {0, 0, -0.5}, sign(false));
      scene_.add_quad({x + 1.3, y_right + 0.02, 2.5}, {-0.6, 0, 0}, {0, 0, -0.6}, sign(true));
    }
    scene_.add_quad({x_front - 0.02, 4.4, 1.9}, {0, -3.6, 0}, {0, 0, -3.4}, gate());
    scene_.add_quad({x_front - 0.02, -5.2, 1.9}, {0, -3.6, 0}, {0, 0, -3.4}, gate());
  }

  Scene& scene_;
  Random random_;
};

}  // namespace

std::unique_ptr<Scene> build_scene(std::uint64_t seed, int threads, double detail) {
  auto scene = std::make_unique<Scene>();
  Furnisher furnisher(*scene, seed_for(seed, 1));
  furnisher.shell();
  furnisher.press();
  furnisher.machines_ahead();
  furnisher.near_floor();
  furnisher.racks();
  furnisher.side_rows();
  furnisher.far_end();
  furnisher.overhead();
  furnisher.ladders();
  TaskPool pool(threads);
  scene->bake(seed_for(seed, 2), pool, detail);
  return scene;
}

}  // namespace rastro::hall
