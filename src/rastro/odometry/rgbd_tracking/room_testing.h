// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "rastro/camera/camera.h"
#include "rastro/math/se3.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// A room of 4 x 3 x 4 m around the origin with a smooth random texture, seen by a camera of 320 x 240 pixels. Every
/// depth is exact.
struct PaperedRoom {
  Camera camera;
  bool papered = true;

  PaperedRoom() {
    camera.width = 320;
    camera.height = 240;
    camera.fx = camera.fy = 260.0;
    camera.cx = 159.5;
    camera.cy = 119.5;
  }

  double shade(const Eigen::Vector3d& p) const {
    if (!papered) return 0.5;
    const auto wave = [](double a, double b) { return std::sin(7.0 * a + 1.3 * std::sin(5.0 * b)); };
    return 0.5 + 0.16 * (wave(p.x(), p.y() + 1.0) + wave(1.3 * p.y(), p.z()) + wave(1.7 * p.z() + 0.4, 1.1 * p.x()));
  }

  Frame frame(std::int64_t index, const SE3& world_from_camera) const {
    Frame frame;
    frame.index = index;
    frame.stamp = frame.depth_stamp = index * (ns_per_second / 30);
    frame.image = GrayImage(camera.width, camera.height);
    frame.depth = DepthImage(camera.width, camera.height);
    const Eigen::Vector3d half(2.0, 1.5, 2.0), from = world_from_camera.translation();
    const Eigen::Matrix3d rotation = world_from_camera.rotation().matrix();
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const Eigen::Vector3d ray =
            rotation * Eigen::Vector3d((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
        double depth = 1e9;
        for (int i = 0; i < 3; ++i) {
          if (std::abs(ray(i)) > 1e-9) depth = std::min(depth, ((ray(i) > 0 ? half(i) : -half(i)) - from(i)) / ray(i));
        }
        frame.depth.at(x, y) = static_cast<float>(depth);
        frame.image.at(x, y) = static_cast<std::uint8_t>(std::lround(255.0 * shade(from + depth * ray)));
      }
    }
    return frame;
  }

  /// Hand-held motion facing a corner of the room.
  static SE3 pose(std::int64_t index) {
    const double t = static_cast<double>(index) / 30.0;
    Vector6d tangent;
    tangent << 0.2 * std::sin(1.1 * t), 0.1 * std::sin(1.7 * t), 0.15 * std::sin(0.9 * t),
        0.1 * std::sin(1.3 * t) + 0.25, 0.2 * std::sin(t) + 0.7, 0.1 * std::sin(0.8 * t);
    return SE3::exp(tangent);
  }
};

}  // namespace rastro
