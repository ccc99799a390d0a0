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
  double noise_px = 0.0;     ///< At the first level; it grows with the pixel size of the others.
  double moved_share = 0.0;  ///< Share of features that are 6 to 20 pixels of their level off.
  double baseline = 0.0;     ///< Above 0: with the depths that stereo measures.
  std::uint64_t seed = 1;
  std::uint32_t from = 0, to = 1000000;  ///< Only these points: from <= point < to.
};

/// A camera's observations of a PointWorld.
struct Observed {
  std::shared_ptr<const FeatureFrame> frame;
  std::vector<std::uint32_t> seen;  ///< The point of each feature.
};

/// For tests only: points with distinctive descriptors in front of a camera at the origin, and frames of them.
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

  /// The order of features differs between frames.
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
      // The right camera has its own error.
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

/// A map of a PointWorld with exact landmarks, observed by its keyframes.
class ExactMap {
  std::unique_ptr<MapGraph> own_;  ///< Null where the graph is given.

 public:
  ExactMap(const PointWorld& world, CameraKind sensor, double baseline)
      : own_(std::make_unique<MapGraph>(world.camera, sensor, baseline, OrbOptions{})),
        graph(*own_),
        landmark_of(world.points.size(), -1),
        world_(world) {}
  /// Uses a given graph, which outlives this.
  ExactMap(const PointWorld& world, MapGraph& given)
      : graph(given), landmark_of(world.points.size(), -1), world_(world) {}

  /// Adds a keyframe that observes the landmarks of all its points; creates those that are missing.
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

  /// The tracked points of a frame that observes them.
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

  MapGraph& graph;
  std::vector<std::int64_t> landmark_of;  ///< One per point; -1: none.

 private:
  const PointWorld& world_;
};

}  // namespace rastro::testing
