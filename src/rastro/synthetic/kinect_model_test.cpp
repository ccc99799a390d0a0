// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/kinect_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "rastro/synthetic/renderer.h"

namespace rastro {
namespace {

constexpr double wall_z = 2.0, thing_z = 1.2;

/// A frontal wall with an object in front of its center, or that alone.
struct Stage {
  std::unique_ptr<Scene> scene = std::make_unique<Scene>();
  Camera camera;
  Image<std::uint16_t> raw;
  RenderedFrame exact;
};

Stage stage(bool with_thing, int threads = 2, float infrared = 1.0F, bool with_wall = true) {
  Stage result;
  Material plain{[](Canvas& canvas, Random&) { canvas.fill(128.0F); }, 10.0};
  plain.infrared = infrared;
  if (with_wall) result.scene->add_box({0, 0, wall_z + 0.5}, {8, 8, 1}, plain);
  if (with_thing) result.scene->add_box({0, 0, thing_z + 0.1}, {0.4, 0.4, 0.2}, plain);
  result.scene->make_tree();
  result.camera.width = 320, result.camera.height = 240;
  result.camera.fx = result.camera.fy = 262.5, result.camera.cx = 159.5, result.camera.cy = 119.5;
  TaskPool pool(threads);
  const Renderer renderer(*result.scene, result.camera);
  result.exact = renderer.cast(SE3(), pool);
  result.raw = kinect_depth(result.exact, renderer, SE3(), KinectModel(), 7, pool);
  return result;
}

TEST(KinectModel, depths_are_quantized_disparities_with_noise) {
  const Stage flat = stage(false);
  const KinectModel model;
  const double strength = flat.camera.fx * model.baseline_m;
  double sum = 0.0, squares = 0.0;
  int measured = 0;
  for (int y = 0; y < flat.camera.height; ++y)
    for (int x = 0; x < flat.camera.width; ++x) {
      ASSERT_GT(flat.raw.at(x, y), 0) << "a wall has no holes, " << x << ' ' << y;
      const double z = flat.raw.at(x, y) / model.units_per_meter, steps = strength / z / model.step_px;
      // Half a unit of the image is a hundredth of a step here.
      ASSERT_NEAR(steps, std::round(steps), 0.012) << z;
      sum += z - wall_z, squares += (z - wall_z) * (z - wall_z), ++measured;
    }
  const double meters_per_px = wall_z * wall_z / strength;
  const double sigma = meters_per_px * std::hypot(model.fine_noise_px, model.coarse_noise_px, model.step_px / 3.46);
  EXPECT_NEAR(std::sqrt(squares / measured), sigma, 0.25 * sigma);
  EXPECT_LT(std::abs(sum / measured), 0.25 * meters_per_px * model.step_px);
}

TEST(KinectModel, holes_are_at_edges_and_in_the_shadow_of_the_projector) {
  const Stage both = stage(true);
  const double shadow_px = both.camera.fx * KinectModel().baseline_m * (1.0 / thing_z - 1.0 / wall_z);
  const double half_px = 0.2 * both.camera.fx / thing_z;
  ASSERT_GT(shadow_px, 4.0);
  int in_shadow = 0, in_shadow_lost = 0;
  for (int y = 0; y < both.camera.height; ++y)
    for (int x = 0; x < both.camera.width; ++x) {
      const double right = x - both.camera.cx, down = y - both.camera.cy;
      const bool lost = both.raw.at(x, y) == 0;
      const bool beside =
          std::abs(down) < half_px - 2.0 && right < -half_px - 2.0 && right > -half_px - shadow_px + 1.5;
      const double reach_left = half_px + shadow_px + 2.0, reach = half_px + 2.0, inside = half_px - 2.0;
      const bool around = right > -reach_left && right < reach && std::abs(down) < reach;
      const bool within = std::abs(right) < inside && std::abs(down) < inside;
      in_shadow += beside ? 1 : 0, in_shadow_lost += beside && lost ? 1 : 0;
      ASSERT_TRUE(!lost || (around && !within)) << x << " " << y;
    }
  EXPECT_GT(in_shadow, 100);
  EXPECT_EQ(in_shadow_lost, in_shadow);
}

/// At the rim of an object before nothing a pixel may take the depth of the one beside it.
TEST(KinectModel, where_no_surface_is_there_is_no_depth) {
  const Stage thing = stage(true, 2, 1.0F, false);
  int measured = 0;
  for (int y = 0; y < thing.camera.height; ++y)
    for (int x = 0; x < thing.camera.width; ++x) {
      measured += thing.raw.at(x, y) != 0 ? 1 : 0;
      ASSERT_TRUE(thing.exact.surface.at(x, y) != no_surface || thing.raw.at(x, y) == 0) << x << ' ' << y;
    }
  EXPECT_GT(measured, 1000);
}

TEST(KinectModel, surfaces_without_infrared_have_no_depth_and_threads_do_not_matter) {
  const Stage dark = stage(true, 1, 0.0F), one = stage(true, 1), eight = stage(true, 8);
  for (int y = 0; y < one.camera.height; ++y)
    for (int x = 0; x < one.camera.width; ++x) {
      ASSERT_EQ(dark.raw.at(x, y), 0);
      ASSERT_EQ(one.raw.at(x, y), eight.raw.at(x, y));
    }
}

}  // namespace
}  // namespace rastro
