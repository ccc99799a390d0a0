// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/sensor_model.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rastro {
namespace {

constexpr int width = 320, height = 240;

Camera camera() { return {width, height, 200, 200, 159.5, 119.5, Distortion::none, {}}; }

DepthImage flat_depth(float meters) {
  DepthImage depth(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) depth.at(x, y) = meters;
  return depth;
}

Image<float> flat_light(float value) { return flat_depth(value); }

SensorModel clean() {
  SensorModel sensor;
  sensor.vignette = sensor.read_noise = sensor.shot_noise = 0.0F;
  return sensor;
}

TEST(SensorModelTest, noise_has_the_given_standard_deviation) {
  SensorModel sensor = clean();
  sensor.read_noise = 1.2F, sensor.shot_noise = 0.02F;
  TaskPool pool(1);
  for (const float value : {40.0F, 120.0F, 200.0F}) {
    const GrayImage gray = expose(flat_light(value), flat_depth(2), camera(), sensor, {}, 5, pool);
    double sum = 0, squares = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) sum += gray.at(x, y), squares += gray.at(x, y) * gray.at(x, y);
    const double mean = sum / (width * height), deviation = std::sqrt(squares / (width * height) - mean * mean);
    // Rounding to whole intensity levels adds a twelfth to the variance.
    const double expected = std::sqrt(1.2 * 1.2 + 0.02 * value + 1.0 / 12.0);
    EXPECT_NEAR(deviation, expected, 0.03 * expected);
    EXPECT_NEAR(mean, value, 0.05);
  }
}

TEST(SensorModelTest, noise_differs_between_seeds_and_not_between_pools) {
  TaskPool one(1), eight(8);
  const auto rendered = [&](std::uint64_t seed, TaskPool& pool) {
    return expose(flat_light(100), flat_depth(2), camera(), SensorModel{}, {}, seed, pool);
  };
  const GrayImage a = rendered(1, one), b = rendered(2, one), c = rendered(1, eight);
  int differ = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      differ += a.at(x, y) != b.at(x, y) ? 1 : 0;
      ASSERT_EQ(a.at(x, y), c.at(x, y));
    }
  EXPECT_GT(differ, width * height / 2);
}

/// Light of a thin cross: the spread of each of its bars gives the blur along x and y.
std::pair<int, int> spread_of_cross(const ShutterMotion& shutter) {
  Image<float> light(width, height);
  for (int y = 0; y < height; ++y) light.at(160, y) = 250.0F;
  for (int x = 0; x < width; ++x) light.at(x, 120) = 250.0F;
  TaskPool pool(1);
  const GrayImage gray = expose(light, flat_depth(2), camera(), clean(), shutter, 1, pool);
  int along_x = 0, along_y = 0;
  for (int i = -40; i <= 40; ++i) {
    along_x += gray.at(160 + i, 60) > 5 ? 1 : 0;
    along_y += gray.at(80, 120 + i) > 5 ? 1 : 0;
  }
  return {along_x, along_y};
}

TEST(SensorModelTest, blur_runs_along_the_motion_and_is_as_long_as_it) {
  ShutterMotion sideways, still, upwards;
  sideways.motion[0] = 0.1;  // 0.1 m at 2 m depth and a focal length of 200 px: 10 px.
  upwards.motion[1] = 0.1;
  EXPECT_EQ(spread_of_cross(still), std::make_pair(1, 1));
  const auto [x, y] = spread_of_cross(sideways);
  EXPECT_NEAR(x, 10, 2);
  EXPECT_EQ(y, 1);
  const auto [x_up, y_up] = spread_of_cross(upwards);
  EXPECT_EQ(x_up, 1);
  EXPECT_NEAR(y_up, 10, 2);
}

TEST(SensorModelTest, vignette_darkens_the_corners_and_gain_everything) {
  SensorModel sensor = clean();
  sensor.vignette = 0.4F, sensor.gain = 1.5F;
  TaskPool pool(1);
  const GrayImage gray = expose(flat_light(100), flat_depth(2), camera(), sensor, {}, 1, pool);
  EXPECT_NEAR(gray.at(160, 120), 150, 1);
  EXPECT_NEAR(gray.at(0, 0), 90, 1);
}

}  // namespace
}  // namespace rastro
