// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "rastro/base/random.h"
#include "rastro/optimize/bundle_adjustment.h"

/// For tests only: a camera trajectory along a scene, exact except for the errors asked for.
namespace rastro::testing {

struct BundleSceneOptions {
  int cameras = 10, fixed = 2, points = 200, views = 5;
  double noise_sigmas = 1.0, outlier_share = 0.0, stereo_share = 0.0;
  double pose_off = 0.02, point_off = 0.1;
};

struct BundleScene {
  Bundle bundle;  ///< Perturbed.
  std::vector<SE3> camera_from_world;
  std::vector<Eigen::Vector3d> points;
};

inline Vector6d random_twist(Random& random, double size) {
  Vector6d twist;
  for (int k = 0; k < 6; ++k) twist[k] = size * (k < 3 ? 1.0 : 0.2) * random.normal();
  return twist;
}

/// Cameras face along z and move along x; every point is observed by the nearest ones. The first and the last cameras
/// are fixed.
inline BundleScene bundle_scene(const BundleSceneOptions& options, std::uint64_t seed) {
  Random random(seed);
  BundleScene scene;
  Bundle& bundle = scene.bundle;
  bundle.baseline = 0.3;
  for (int i = 0; i < options.cameras; ++i) {
    const SE3 pose(SO3::exp({0.02 * std::sin(i), 0.03 * std::cos(i), 0.01 * i}), {-0.4 * i, 0.05 * std::sin(i), 0.0});
    scene.camera_from_world.push_back(pose);
    const bool fixed = i < (options.fixed + 1) / 2 || i >= options.cameras - options.fixed / 2;
    bundle.fixed.push_back(fixed ? 1 : 0);
    bundle.camera_from_world.push_back(fixed ? pose : SE3::exp(random_twist(random, options.pose_off)) * pose);
  }
  for (int i = 0; i < options.points; ++i) {
    const int first =
        static_cast<int>(random.below(static_cast<std::uint32_t>(std::max(1, options.cameras - options.views + 1))));
    const double depth = random.uniform(3.0, 12.0);
    const double x = 0.4 * (first + 0.5 * options.views) + random.uniform(-0.3, 0.3) * depth;
    const Eigen::Vector3d point(x, random.uniform(-0.3, 0.3) * depth, depth);
    scene.points.push_back(point);
    const double dx = random.normal(), dy = random.normal(), dz = random.normal();
    bundle.points.push_back(point + options.point_off * Eigen::Vector3d(dx, dy, dz));
    for (int k = 0; k < std::min(options.views, options.cameras); ++k) {
      BundleObservation seen;
      seen.camera = static_cast<std::uint32_t>(first + k);
      seen.point = static_cast<std::uint32_t>(i);
      seen.sigma = (k % 2 == 0 ? 1.0 : 1.2) / 500.0;
      const Eigen::Vector3d p = scene.camera_from_world[seen.camera] * point;
      const double noise = options.noise_sigmas * seen.sigma;
      const bool outlier = random.uniform() < options.outlier_share;
      const double off_x = noise * random.normal(), off_y = noise * random.normal(), off_r = noise * random.normal();
      seen.ray = p.hnormalized() + Eigen::Vector2d(off_x + (outlier ? 0.1 : 0.0), off_y);
      if (random.uniform() < options.stereo_share) seen.right_x = (p.x() - bundle.baseline) / p.z() + off_r;
      bundle.observations.push_back(seen);
    }
  }
  return scene;
}

}  // namespace rastro::testing
