// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/texture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/synthetic/paint/canvas.h"
#include "rastro/synthetic/worlds/hall_materials.h"

namespace rastro {
namespace {

TEST(TextureTest, a_footprint_of_the_whole_image_gives_its_mean) {
  Canvas canvas(1.0, 1.0, 64);
  Random random(1);
  canvas.fill(100.0F);
  canvas.rectangle(0, 0, 0.5, 1.0, 200.0F);
  const Texture texture(canvas.values());
  EXPECT_NEAR(texture.sample(32, 32, 64, 0, 0, 64), 150.0F, 3.0F);
  EXPECT_NEAR(texture.sample(16, 32, 1, 0, 0, 1), 200.0F, 1.0F);
  EXPECT_NEAR(texture.sample(48, 32, 1, 0, 0, 1), 100.0F, 1.0F);
}

TEST(TextureTest, long_footprints_stay_sharp_across) {
  Canvas canvas(1.0, 1.0, 64);
  canvas.fill(0.0F);
  canvas.rectangle(0, 0, 1.0, 0.5, 200.0F);
  const Texture texture(canvas.values());
  // Six texels along the edge, one across: an isotropic footprint of six would mix both sides here.
  EXPECT_NEAR(texture.sample(32, 29, 6, 0, 0, 1), 200.0F, 1.0F);
  EXPECT_NEAR(texture.sample(32, 35, 6, 0, 0, 1), 0.0F, 1.0F);
}

/// Highest correlation of an image with itself shifted by 16 texels and more.
double highest_repeat(const Image<float>& values) {
  const int width = values.width(), height = values.height();
  double mean = 0.0, variance = 0.0, highest = 0.0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) mean += values.at(x, y) / (width * height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) variance += std::pow(values.at(x, y) - mean, 2) / (width * height);
  for (int dy = 0; dy <= height / 2; dy += 2)
    for (int dx = 0; dx <= width / 2; dx += 2) {
      if (dx < 16 && dy < 16) continue;
      double sum = 0.0;
      for (int y = 0; y + dy < height; ++y)
        for (int x = 0; x + dx < width; ++x) sum += (values.at(x, y) - mean) * (values.at(x + dx, y + dy) - mean);
      highest = std::max(highest, sum / (variance * (width - dx) * (height - dy)));
    }
  return highest;
}

TEST(TextureTest, noise_and_machines_do_not_repeat) {
  Canvas noise(2.0, 2.0, 48), machine(3.0, 3.0, 32), tiled(2.0, 2.0, 48);
  Random random(2);
  noise.add_noise(random, 0.3, 20.0F, 0.8F);
  hall::machine(120).paint(machine, random);
  EXPECT_LT(highest_repeat(noise.values()), 0.5);
  EXPECT_LT(highest_repeat(machine.values()), 0.5);
  tiled.stripes(0, 0, 2, 2, 0.5, 0, 200);
  EXPECT_GT(highest_repeat(tiled.values()), 0.9) << "this measure must detect repetition";
}

TEST(TextureTest, drawing_does_not_depend_on_the_number_of_texels) {
  const auto mean_at = [](double density) {
    Canvas canvas(1.5, 1.5, density);
    Random random(8);
    hall::machine(120).paint(canvas, random);
    return Texture(canvas.values())
        .sample(static_cast<float>(0.4 * density), static_cast<float>(0.4 * density), static_cast<float>(0.4 * density),
                0, 0, static_cast<float>(0.4 * density));
  };
  EXPECT_NEAR(mean_at(60), mean_at(120), 6.0F);
}

}  // namespace
}  // namespace rastro
