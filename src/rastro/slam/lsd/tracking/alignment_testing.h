// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>

#include "rastro/base/random.h"
#include "rastro/slam/lsd/inverse_depth_map.h"
#include "rastro/slam/lsd/tracking/alignment_reference.h"
#include "rastro/synthetic/renderer.h"

/// For tests and benchmarks only.
namespace rastro::testing {

/// Painted walls, a floor and boxes at 1.5 to 5 m in front of a pinhole camera at the origin (x right, y down, z
/// forward), rendered exactly and without any effect of a sensor.
class AlignmentRoom {
 public:
  explicit AlignmentRoom(int width = 320, int height = 240)
      : pool_(2), scene_(made_scene(pool_)), camera_(camera_of(width, height)), renderer_(scene_, camera_) {}

  const Camera& camera() const { return camera_; }
  const Renderer& renderer() const { return renderer_; }

  RenderedFrame render(const SE3& world_from_camera) {
    SensorModel ideal;
    ideal.exposure_time_s = 0.0, ideal.vignette = 0.0F, ideal.read_noise = 0.0F, ideal.shot_noise = 0.0F;
    return renderer_.render(world_from_camera, ideal, {}, 1, pool_);
  }

 private:
  static Camera camera_of(int width, int height) {
    Camera camera;
    camera.width = width, camera.height = height;
    camera.fx = camera.fy = 0.8 * width;
    camera.cx = 0.5 * (width - 1), camera.cy = 0.5 * (height - 1);
    return camera;
  }

  /// Blotches with edges of several sizes on a smooth ground.
  static Material blotched(float tone) {
    return {[tone](Canvas& canvas, Random& random) {
              canvas.fill(tone);
              canvas.add_noise(random, 1.0, 25.0F, 0.6F);
              for (int i = 0; i < static_cast<int>(25.0 * canvas.width() * canvas.height()); ++i) {
                const double x = random.uniform(0.0, canvas.width()), y = random.uniform(0.0, canvas.height());
                const auto value = static_cast<float>(random.uniform(25.0, 215.0));
                canvas.disc(x, y, random.uniform(0.02, 0.12), value, 0.8F);
              }
            },
            120.0};
  }

  static Scene made_scene(TaskPool& pool) {
    Scene scene;
    scene.add_quad({0, 0, 5}, {12, 0, 0}, {0, 8, 0}, blotched(120.0F));
    scene.add_quad({0, 1.2, 3}, {8, 0, 0}, {0, 0, -6}, blotched(90.0F));
    scene.add_box({-0.9, 0.5, 3.0}, {0.8, 1.2, 0.8}, blotched(140.0F));
    scene.add_box({0.8, 0.2, 2.4}, {0.6, 0.7, 0.6}, blotched(110.0F));
    scene.add_box({0.1, -0.7, 3.8}, {1.4, 0.5, 0.5}, blotched(100.0F));
    scene.bake(5, pool);
    return scene;
  }

  TaskPool pool_;
  Scene scene_;
  Camera camera_;
  Renderer renderer_;
};

/// The inverse depth of the pixels with at least this central difference (levels per pixel), with normal errors of
/// `relative_sigma` times the value; the variance is theirs, or that of 1 % without errors.
inline InverseDepthMap semi_dense_depth(const RenderedFrame& frame, double min_gradient, double relative_sigma,
                                        std::uint64_t seed) {
  Random random(seed);
  InverseDepthMap map(frame.gray.width(), frame.gray.height());
  for (int y = 1; y < map.height() - 1; ++y) {
    for (int x = 1; x < map.width() - 1; ++x) {
      const double gx = 0.5 * (frame.gray.at(x + 1, y) - frame.gray.at(x - 1, y));
      const double gy = 0.5 * (frame.gray.at(x, y + 1) - frame.gray.at(x, y - 1));
      const auto depth = static_cast<double>(frame.depth.at(x, y));
      if (std::hypot(gx, gy) < min_gradient || depth <= 0.0) continue;
      const double sigma = (relative_sigma > 0.0 ? relative_sigma : 0.01) / depth;
      map.mean.at(x, y) = static_cast<float>(1.0 / depth * (1.0 + relative_sigma * random.normal()));
      map.variance.at(x, y) = static_cast<float>(sigma * sigma);
    }
  }
  return map;
}

/// gain * image + offset + normal noise, rounded and clipped as a sensor does.
inline GrayImage exposed(const GrayImage& image, double gain, double offset, double noise_sigma, std::uint64_t seed) {
  Random random(seed);
  GrayImage result(image.width(), image.height());
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double noise = noise_sigma > 0.0 ? noise_sigma * random.normal() : 0.0;
      const double value = std::round(gain * image.at(x, y) + offset + noise);
      result.at(x, y) = static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
    }
  }
  return result;
}

}  // namespace rastro::testing
