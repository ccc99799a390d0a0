// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/math/se3.h"

/// For tests only: points observed by two cameras of focal length 500 px, exact unless noise is requested.
namespace rastro::testing {

struct TwoViewScene {
  SE3 second_from_first;
  std::vector<Eigen::Vector3d> points;  ///< In the first camera's frame.
  std::vector<Eigen::Vector2d> a, b;    ///< Normalized.
  std::vector<bool> is_outlier;
};

struct SceneOptions {
  int count = 100;
  double noise_px = 0.0;
  double outlier_share = 0.0;
  bool planar = false;
};

inline Eigen::Vector2d random_point(Random& random) { return {random.uniform(-0.9, 0.9), random.uniform(-0.5, 0.5)}; }

/// Depths of 3 to 20 m, or a slanted plane.
inline TwoViewScene two_view_scene(Random& random, const SE3& second_from_first, const SceneOptions& options) {
  TwoViewScene scene;
  scene.second_from_first = second_from_first;
  const double noise = options.noise_px / 500.0;
  while (static_cast<int>(scene.a.size()) < options.count) {
    const Eigen::Vector2d pixel = random_point(random);
    const double depth = options.planar ? 8.0 / (1.0 + 0.3 * pixel.x() - 0.5 * pixel.y()) : random.uniform(3.0, 20.0);
    const Eigen::Vector3d point = depth * pixel.homogeneous(), other = second_from_first * point;
    if (other.z() < 0.5) continue;
    // Drawn one by one: the evaluation order of arguments is up to the compiler.
    const double off_x = noise * random.normal(), off_y = noise * random.normal();
    const Eigen::Vector2d off(off_x, off_y);
    scene.is_outlier.push_back(random.uniform() < options.outlier_share);
    scene.points.push_back(point);
    scene.a.push_back(pixel);
    scene.b.push_back((scene.is_outlier.back() ? random_point(random) : Eigen::Vector2d(other.hnormalized())) + off);
  }
  return scene;
}

inline SE3 some_motion() { return SE3(SO3::exp({0.02, -0.08, 0.01}), {0.3, -0.05, -0.9}); }

/// Angle between two directions, radians.
inline double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace rastro::testing
