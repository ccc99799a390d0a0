// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/base/task_pool.h"
#include "rastro/map/graph/map.h"
#include "rastro/map/images/pack_images.h"
#include "rastro/synthetic/path.h"
#include "rastro/synthetic/renderer.h"

namespace rastro {

/// A wall (x = 3) with a box 0.32 x 0.25 m on a shelf in front of it, whose front is x = 2, and a bed 2 m long, its top
/// at z = 0.4. World: z up, meters. Rendered once; each map made from it has its own noise.
class LengthRoom {
 public:
  static constexpr int keyframes = 10;

  explicit LengthRoom(int threads = 2) : pool_(threads), scene_(made_scene()) {
    scene_.bake(1, pool_);
    camera_.width = 400, camera_.height = 300;
    camera_.fx = camera_.fy = 330.0, camera_.cx = 199.5, camera_.cy = 149.5;
    const Renderer renderer(scene_, camera_);
    SensorModel sensor;
    sensor.exposure_time_s = 0.0;
    for (int k = 0; k < keyframes; ++k) frames_.push_back(renderer.render(true_pose(k), sensor, {}, 7 + k, pool_));
  }

  /// From one side to the other, panning and tilting; every one shows the box, few the whole bed.
  static SE3 true_pose(int k) {
    const double share = static_cast<double>(k) / (keyframes - 1);
    return {looking(0.35 - 0.7 * share + 0.25 * std::sin(2.1 * k), 0.30 + 0.06 * std::cos(1.3 * k), 0.03 * std::sin(k)),
            {-0.1 + 0.2 * std::sin(1.7 * k), -0.5 + share, 1.35 + 0.08 * std::cos(k)}};
  }

  /// Depth with the noise of a Kinect: disparity in steps of 1/8 px with noise. Keyframe poses are the true ones but
  /// for noise of `pose_noise_m` along each axis and a tenth of it (rad) about each. No depth where `hidden` is true.
  template <typename Occluded>
  Map map(std::uint64_t seed, double pose_noise_m, Occluded&& hidden) const {
    Map map;
    map.method = "rgbd";
    map.cameras.push_back({CameraKind::depth, camera_, 0.0, {}, SE3()});
    auto images = std::make_shared<ImageLayer>();
    auto memory_images = std::make_shared<MemoryImages>();
    Random random(seed);
    for (int k = 0; k < keyframes; ++k) {
      Vector6d error;
      for (int i = 0; i < 6; ++i) error[i] = random.normal() * pose_noise_m * (i < 3 ? 1.0 : 0.1);
      const TimeNs stamp = TimeNs{k} * ns_per_second;
      map.keyframes.push_back({k, k, stamp, 0, true_pose(k) * SE3::exp(error), 0, no_keyframe, 1.0});
      map.frames.push_back({stamp, k, SE3()});
      images->keyframes.push_back(k);
      Frame frame;
      frame.image = frames_[static_cast<std::size_t>(k)].gray;
      frame.depth = measured(frames_[static_cast<std::size_t>(k)].depth, true_pose(k), random, hidden);
      memory_images->add(k, pack_images(frame));
    }
    images->store = memory_images;
    map.layers.put<ImageLayer>(std::move(images));
    return map;
  }
  Map map(std::uint64_t seed, double pose_noise_m) const {
    return map(seed, pose_noise_m, [](const Eigen::Vector3d&) { return false; });
  }

  TaskPool& pool() const { return pool_; }

 private:
  static Material plain(float tone, double coarsest_m = 0.3) {
    return {[tone, coarsest_m](Canvas& canvas, Random& random) {
              canvas.fill(tone);
              canvas.add_noise(random, coarsest_m, 4.0F, 0.8F);
            },
            150.0};
  }

  static Scene made_scene() {
    Scene scene;
    scene.add_quad({3, 0, 1}, {0, -8, 0}, {0, 0, -4}, plain(180.0F));
    scene.add_box({2, 0, -0.05}, {6, 8, 0.1}, plain(120.0F));
    const std::uint32_t box = scene.add_box({2.1, 0, 1.0}, {0.2, 0.32, 0.25}, plain(60.0F));
    scene.paint_face(box, 4, plain(130.0F));
    scene.add_box({2.175, 0, 0.85}, {0.45, 1.2, 0.05}, plain(110.0F));
    scene.add_box({1.6, 0, 0.2}, {0.7, 2.0, 0.4}, plain(200.0F));
    return scene;
  }

  template <typename Occluded>
  DepthImage measured(const DepthImage& exact, const SE3& world_from_camera, Random& random, Occluded&& hidden) const {
    constexpr double kinect = 525.0 * 0.075, step = 0.125;
    DepthImage depth(exact.width(), exact.height());
    for (int y = 0; y < exact.height(); ++y) {
      for (int x = 0; x < exact.width(); ++x) {
        const auto z = static_cast<double>(exact.at(x, y));
        const Eigen::Vector3d ray((x - camera_.cx) / camera_.fx, (y - camera_.cy) / camera_.fy, 1.0);
        if (!(z > 0.4 && z < 6.0) || hidden(world_from_camera * (z * ray))) continue;
        const double disparity = std::round((kinect / z + 0.1 * random.normal()) / step) * step;
        depth.at(x, y) = static_cast<float>(kinect / disparity);
      }
    }
    return depth;
  }

  mutable TaskPool pool_;
  Scene scene_;
  Camera camera_;
  std::vector<RenderedFrame> frames_;
};

}  // namespace rastro
