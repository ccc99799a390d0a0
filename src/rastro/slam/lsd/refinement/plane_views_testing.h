// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/camera/camera.h"
#include "rastro/slam/lsd/refinement/photometric_bundle.h"

/// For tests only.
namespace rastro::testing {

/// Smooth structure everywhere on the plane z = 2 + 0.3 x, at several sizes.
inline double texture(double x, double y) {
  return 128.0 + 40.0 * std::sin(9.0 * x + 2.0 * y) + 35.0 * std::sin(7.0 * y - 4.0 * x) + 20.0 * std::sin(23.0 * x) +
         20.0 * std::sin(19.0 * y);
}

inline Camera plane_camera() {
  Camera camera;
  camera.width = 160, camera.height = 120;
  camera.fx = camera.fy = 140.0;
  camera.cx = 79.5, camera.cy = 59.5;
  return camera;
}

/// Depth along the optical axis where the ray of a pixel meets the plane.
inline double depth_at(const SE3& world_from_camera, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d normal(-0.3, 0.0, 1.0);
  const Eigen::Vector3d direction = world_from_camera.rotation() * ray;
  return (2.0 - normal.dot(world_from_camera.translation())) / normal.dot(direction);
}

/// Five cameras beside each other before the plane.
struct PlaneViews {
  std::vector<SE3> world_from_camera;
  std::vector<GrayImage> images;
  std::vector<PhotometricKeyframe> keyframes;

  explicit PlaneViews(double gain = 1.0) {
    const Camera camera = plane_camera();
    for (int k = 0; k < 5; ++k) {
      world_from_camera.emplace_back(SO3::exp({0.01 * k, -0.02 * k, 0.01 * k}),
                                     Eigen::Vector3d(0.08 * k, 0.03 * (k % 2), 0.02 * k));
      GrayImage& image = images.emplace_back(camera.width, camera.height);
      const double brightness = k % 2 > 0 ? gain : 1.0;
      for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
          const Eigen::Vector3d ray((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1.0);
          const Eigen::Vector3d point = world_from_camera.back() * (depth_at(world_from_camera.back(), ray) * ray);
          image.at(x, y) = static_cast<std::uint8_t>(std::lround(brightness * texture(point.x(), point.y())));
        }
    }
    for (int k = 0; k < 5; ++k) keyframes.push_back(keyframe(k));
  }

  PhotometricKeyframe keyframe(int k) const {
    const Camera camera = plane_camera();
    const auto index = static_cast<std::size_t>(k);
    PhotometricKeyframe made{images[index].view(), world_from_camera[index].inverse(), k == 0, {}, {}};
    for (int y = 10; y < camera.height - 10; y += 9)
      for (int x = 10; x < camera.width - 10; x += 9)
        made.points.push_back({x, y,
                               1.0 / depth_at(world_from_camera[index],
                                              {(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1.0})});
    for (int other = 0; other < 5; ++other)
      if (other != k) made.targets.push_back(other);
    return made;
  }

  /// Poses off by about 3 mm and 0.1 degrees, and depths by 3 %.
  void disturb(std::uint64_t seed) {
    Random random(seed);
    for (PhotometricKeyframe& keyframe : keyframes) {
      Vector6d move;
      for (int i = 0; i < 6; ++i) move[i] = (i < 3 ? 0.003 : 0.002) * random.normal();
      if (!keyframe.fixed) keyframe.camera_from_world = SE3::exp(move) * keyframe.camera_from_world;
      for (PhotometricPoint& point : keyframe.points) point.inverse_depth *= 1.0 + 0.03 * random.normal();
    }
  }

  /// Largest error of a direction of motion from the first camera and of a rotation, radians. The scale is free.
  double error() const {
    double largest = 0.0;
    for (std::size_t k = 1; k < keyframes.size(); ++k) {
      const SE3 found = keyframes[k].camera_from_world.inverse();
      const Eigen::Vector3d a = found.translation().normalized(), b = world_from_camera[k].translation().normalized();
      largest = std::max(
          {largest, (a - b).norm(), (found.rotation() * world_from_camera[k].rotation().inverse()).log().norm()});
    }
    return largest;
  }
  double scale() const {
    return keyframes.back().camera_from_world.inverse().translation().norm() /
           world_from_camera.back().translation().norm();
  }
  double depth_error() const {
    double sum = 0.0;
    int count = 0;
    for (std::size_t k = 0; k < keyframes.size(); ++k) {
      const PhotometricKeyframe truth = keyframe(static_cast<int>(k));
      for (std::size_t i = 0; i < truth.points.size(); ++i, ++count)
        sum += std::abs(scale() * keyframes[k].points[i].inverse_depth / truth.points[i].inverse_depth - 1.0);
    }
    return sum / count;
  }
};

}  // namespace rastro::testing
