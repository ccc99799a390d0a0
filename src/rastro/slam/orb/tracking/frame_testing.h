// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/slam/orb/map/map_graph.h"
#include "rastro/slam/orb/tracking/frame_tracker.h"

namespace rastro::testing {

struct ObserveOptions {
  double noise_px = 0.0;     ///< Of the first level; that of the others grows as their pixels do.
  double moved_share = 0.0;  ///< Of features that are 6 to 20 pixels of their level from where they belong.
  double baseline = 0.0;     ///< Above 0: with the depths that two cameras see.
  std::uint64_t seed = 1;
  std::uint32_t from = 0, to = 1000000;  ///< Only these points: from <= point < to.
};

/// What a camera sees of a PointWorld.
struct Observed {
  std::shared_ptr<const FeatureFrame> frame;
  std::vector<std::uint32_t> seen;  ///< The point of each feature.
};

/// For tests only: points that each look like nothing else, in front of a camera at the origin, and frames of them.
class PointWorld {
 public:
  PointWorld(int count, std::uint64_t seed, double near = 4.0, double far = 12.0) {
    Random random(seed);
    for (int i = 0; i < count; ++i) {
      const double x = random.uniform(-0.5, 0.5), y = random.uniform(-0.35, 0.35), z = random.uniform(near, far);
      points.emplace_back(x * z, y * z, z);
      Descriptor descriptor;
      for (auto& word : descriptor.words) word = random.next();
      descriptors.push_back(descriptor);
    }
    camera.width = 640;
    camera.height = 480;
    camera.fx = camera.fy = 500.0;
    camera.cx = 319.5;
    camera.cy = 239.5;
  }

  /// Features are in another order in each frame.
  Observed observe(std::int64_t id, const SE3& camera_from_world, const ObserveOptions& options = {}) const {
    Random random(options.seed);
    auto data = std::make_shared<ImageFeatures>();
    data->id = data->frame = id;
    data->stamp = 100000000 * (id + 1);
    Observed observed;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const auto i = static_cast<std::uint32_t>((k + 37 * static_cast<std::size_t>(id + 1)) % points.size());
      const Eigen::Vector3d p = camera_from_world * points[i];
      const auto pixel = camera.project(p);
      if (i < options.from || i >= options.to || !pixel) continue;
      if (pixel->x() < 0 || pixel->y() < 0 || pixel->x() > 639 || pixel->y() > 479) continue;
      const auto level =
          static_cast<std::uint8_t>(std::clamp(std::round(std::log(15.0 / p.norm()) / std::log(1.2)), 0.0, 7.0));
      const double scale = std::pow(1.2, level), right_error = options.noise_px * scale * random.normal();
      const Eigen::Vector2d off = error(random, options, scale), at = *pixel + off;
      data->features.keypoints.push_back({static_cast<float>(at.x()), static_cast<float>(at.y()), 31, 0, 1});
      data->features.levels.push_back(level);
      data->features.descriptors.push_back(descriptors[i]);
      // The right camera errs on its own.
      const double disparity = camera.fx * options.baseline / p.z() + off.x() - right_error;
      const double depth = disparity > 0.1 ? camera.fx * options.baseline / disparity : 0.0;
      if (options.baseline > 0.0) data->depths.push_back(static_cast<float>(depth));
      observed.seen.push_back(i);
    }
    observed.frame = std::make_shared<FeatureFrame>(std::move(data), camera, options.baseline);
    return observed;
  }

  std::vector<Eigen::Vector3d> points;
  std::vector<Descriptor> descriptors;
  Camera camera;

 private:
  static Eigen::Vector2d error(Random& random, const ObserveOptions& options, double scale) {
    const double x = random.normal(), y = random.normal(), angle = random.uniform(0.0, 2.0 * M_PI);
    const double far = scale * random.uniform(6.0, 20.0);
    if (random.uniform() < options.moved_share) return far * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    return options.noise_px * scale * Eigen::Vector2d(x, y);
  }
};

/// A map of a PointWorld: where the landmarks are that its keyframes see, exactly.
class ExactMap {
 public:
  ExactMap(const PointWorld& world, CameraKind sensor, double baseline)
      : graph(world.camera, sensor, baseline, OrbOptions{}), landmark_of(world.points.size(), -1), world_(world) {}

  /// A keyframe that sees all landmarks of its points; those that have none get one.
  std::int64_t add(std::int64_t id, const SE3& camera_from_world, ObserveOptions options = {}, int submap = 0) {
    options.baseline = graph.baseline();
    const Observed observed = world_.observe(id, camera_from_world, options);
    const std::vector<std::int64_t> before = graph.keyframe_ids(submap);
    graph.add_keyframe(observed.frame, camera_from_world, submap, before.empty() ? -1 : before.back());
    for (std::uint32_t feature = 0; feature < observed.seen.size(); ++feature) {
      std::int64_t& landmark = landmark_of[observed.seen[feature]];
      if (landmark < 0) landmark = graph.add_landmark(world_.points[observed.seen[feature]], id).id;
      graph.add_observation(id, feature, landmark);
      graph.describe(landmark);
    }
    return id;
  }

  /// What a tracker would say of a frame that shows them.
  std::vector<TrackedPoint> tracked(const Observed& observed) const {
    std::vector<TrackedPoint> points;
    for (std::uint32_t feature = 0; feature < observed.seen.size(); ++feature) {
      const std::int64_t landmark = landmark_of[observed.seen[feature]];
      if (landmark < 0) continue;
      TrackedPoint point;
      point.feature = feature;
      point.landmark = landmark;
      point.position = graph.landmark(landmark).position;
      points.push_back(point);
    }
    return points;
  }

  MapGraph graph;
  std::vector<std::int64_t> landmark_of;  ///< One a point; -1: none.

 private:
  const PointWorld& world_;
};

}  // namespace rastro::testing
