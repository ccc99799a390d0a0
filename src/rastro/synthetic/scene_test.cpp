// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/scene.h"

#include <gtest/gtest.h>

#include <numbers>

#include "rastro/synthetic/intersect.h"
#include "rastro/synthetic/path.h"
#include "rastro/synthetic/renderer.h"

namespace rastro {
namespace {

using Eigen::Vector3d;

Material noisy() {
  return {[](Canvas& canvas, Random& random) {
            canvas.fill(120.0F);
            canvas.add_noise(random, 0.5, 20.0F, 0.8F);
          },
          40.0};
}

/// One of each solid, in front of a wall.
Scene small_scene() {
  Scene scene;
  scene.add_quad({10, 0, 0}, {0, -40, 0}, {0, 0, -40}, noisy());
  scene.add_box({4, 1, 0}, {1, 1.2, 1.4}, noisy(), 0.4);
  scene.add_cylinder({5, -1, -1}, {4.5, -1.6, 1.2}, 0.4, noisy());
  scene.add_sphere({3.5, 0, 0.9}, 0.5, noisy());
  scene.add_box({6, 0, -1.5}, {2, 6, 0.2}, noisy());
  TaskPool pool(1);
  scene.bake(1, pool);
  return scene;
}

SE3 start() { return {looking(0.05, 0.02, 0.1), {0.1, 0.05, 0.02}}; }

Camera bent_camera() {
  Camera camera{192, 120, 114.6, 114.3, 91.8, 62.1, Distortion::radial_tangential, {-0.28, 0.07, 0.0002, 0.00002, 0}};
  return camera;
}

TEST(SceneTest, a_ray_hits_a_sphere_at_the_exact_point) {
  Scene scene;
  scene.add_sphere({5, 0, 0}, 1.0, noisy());
  const auto hit = scene.trace({0, 0, 0}, {1, 0, 0});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->t, 4.0, 1e-12);
  EXPECT_FALSE(scene.trace({0, 0, 0}, {1, 0.21, 0}));
  EXPECT_FALSE(scene.trace({0, 0, 0}, {-1, 0, 0})) << "behind the ray";
  EXPECT_FALSE(scene.trace({0, 0, 0}, {1, 0, 0}, 3.9)) << "beyond the limit";
}

TEST(SceneTest, hits_are_on_the_reported_surface) {
  const Scene scene = small_scene();
  Random random(3);
  int met[4] = {};
  for (int i = 0; i < 4000; ++i) {
    const auto hit = scene.trace({0, 0, 0}, {1, random.uniform(-0.5, 0.5), random.uniform(-0.4, 0.4)});
    if (!hit) continue;
    const Primitive& solid = scene.primitives()[scene.surfaces()[hit->surface].primitive];
    const Vector3d local = to_local(solid, hit->point - solid.center);
    ++met[static_cast<int>(solid.shape)];
    switch (solid.shape) {
      case Shape::box:
        EXPECT_NEAR((local.cwiseAbs() - solid.half).maxCoeff(), 0.0, 1e-9);
        break;
      case Shape::quad:
        EXPECT_NEAR(local.z(), 0.0, 1e-9);
        break;
      case Shape::sphere:
        EXPECT_NEAR(local.norm(), solid.half.x(), 1e-9);
        break;
      case Shape::cylinder:
        EXPECT_NEAR(std::max(local.head<2>().norm() - solid.half.x(), std::abs(local.z()) - solid.half.z()), 0.0, 1e-9);
        break;
    }
  }
  for (const int count : met) EXPECT_GT(count, 50);
}

TEST(SceneTest, nothing_nearer_is_missed_by_the_tree) {
  const Scene scene = small_scene();
  Random random(5);
  for (int i = 0; i < 3000; ++i) {
    const Vector3d origin(random.uniform(-1, 2), random.uniform(-1, 1), random.uniform(-1, 1));
    const Vector3d direction(random.normal(), random.normal(), random.normal());
    double nearest = 1e9;
    for (const Primitive& solid : scene.primitives())
      nearest = std::min(nearest, intersect(solid, to_local(solid, origin - solid.center), direction).t);
    const auto hit = scene.trace(origin, direction);
    EXPECT_EQ(hit ? hit->t : 1e9, nearest);
  }
}

TEST(SceneTest, face_axes_are_perpendicular_and_give_the_point) {
  const Scene scene = small_scene();
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const auto hit = scene.trace({0, 0, 0}, {1, random.uniform(-0.5, 0.5), random.uniform(-0.4, 0.4)});
    if (!hit) continue;
    const FacePoint here = scene.face_point(hit->surface, hit->point);
    EXPECT_NEAR(here.normal.dot(here.along_u), 0.0, 1e-9);
    EXPECT_NEAR(here.normal.dot(here.along_v), 0.0, 1e-9);
    EXPECT_GT(here.along_u.cross(-here.along_v).dot(here.normal), 0.0) << "letters would be mirrored";
    const double step = 1e-5;
    const FacePoint beside = scene.face_point(hit->surface, hit->point + step * here.along_v);
    EXPECT_NEAR((beside.v - here.v) / step, 1.0, 1e-3);
    const Surface& surface = scene.surfaces()[hit->surface];
    EXPECT_TRUE(here.u > -1e-9 && here.u < surface.width + 1e-9 && here.v > -1e-9 && here.v < surface.height + 1e-9);
  }
}

TEST(RendererTest, depth_and_surface_equal_the_trace_at_every_pixel) {
  const Scene scene = small_scene();
  const Renderer renderer(scene, bent_camera());
  TaskPool pool(2);
  const RenderedFrame frame = renderer.render(start(), {}, {}, 1, pool);
  int surfaces = 0;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 192; ++x) {
      const auto hit = scene.trace(start().translation(), start().rotation().matrix() * renderer.ray(x, y));
      ASSERT_TRUE(hit);
      ASSERT_EQ(frame.depth.at(x, y), static_cast<float>(hit->t)) << x << " " << y;
      ASSERT_EQ(frame.surface.at(x, y), hit->surface);
      surfaces += x > 0 && frame.surface.at(x, y) != frame.surface.at(x - 1, y) ? 1 : 0;
    }
  EXPECT_GT(surfaces, 300) << "the test scene must show edges";
}

TEST(RendererTest, a_visible_point_projects_back_to_its_pixel) {
  const Scene scene = small_scene();
  const Renderer renderer(scene, bent_camera());
  TaskPool pool(1);
  const RenderedFrame frame = renderer.render(start(), {}, {}, 1, pool);
  for (int y = 0; y < 120; y += 7)
    for (int x = 0; x < 192; x += 7) {
      const auto pixel = renderer.camera().project(renderer.ray(x, y) * frame.depth.at(x, y));
      ASSERT_TRUE(pixel);
      EXPECT_NEAR((*pixel - Eigen::Vector2d(x, y)).norm(), 0.0, 1e-4);
    }
}

TEST(RendererTest, same_bytes_for_any_number_of_threads) {
  const Scene scene = small_scene();
  const Renderer renderer(scene, bent_camera());
  ShutterMotion shutter;
  shutter.motion << 0.01, 0, 0, 0, 0.01, 0;
  TaskPool one(1);
  const RenderedFrame reference = renderer.render(start(), {}, shutter, 9, one);
  for (const int threads : {2, 8}) {
    TaskPool pool(threads);
    const RenderedFrame frame = renderer.render(start(), {}, shutter, 9, pool);
    for (int y = 0; y < 120; ++y) {
      ASSERT_EQ(0, std::memcmp(frame.gray.row(y), reference.gray.row(y), 192));
      ASSERT_EQ(0, std::memcmp(frame.depth.row(y), reference.depth.row(y), 192 * sizeof(float)));
      ASSERT_EQ(0, std::memcmp(frame.surface.row(y), reference.surface.row(y), 192 * sizeof(std::uint32_t)));
    }
  }
}

}  // namespace
}  // namespace rastro
