// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "rastro/slam/orb/local_mapping/local_mapping.h"
#include "rastro/slam/orb/tracking/frame_testing.h"

namespace rastro::testing {

/// For tests only: pose of keyframe k, as camera_from_world.
inline SE3 mapping_pose(int k) { return SE3(SO3::exp({0.0, 0.01 * k, 0.005 * k}), {-0.3 * k, 0.02 * k, 0.0}); }

/// A map with ground truth: every landmark must be at the point that its features show.
struct MappingBench {
  explicit MappingBench(CameraKind sensor, const OrbSlamOptions& changed = {})
      : options(changed),
        world(200, 11),
        map(world, sensor, sensor == CameraKind::mono ? 0.0 : 0.1),
        mapping(options, map.graph, nullptr) {}

  Observed observe(std::int64_t id, const SE3& camera_from_world, ObserveOptions how = {}) {
    how.baseline = map.graph.baseline();
    const Observed result = world.observe(id, camera_from_world, how);
    seen.resize(static_cast<std::size_t>(id) + 1);
    seen.back() = result.seen;
    return result;
  }
  /// Adds a keyframe of the exact map, not through mapping.
  void add_keyframe(std::int64_t id, ObserveOptions how = {}) {
    observe(id, mapping_pose(static_cast<int>(id)), how);
    map.add(id, mapping_pose(static_cast<int>(id)), how);
  }
  void forget_second_half() {
    for (std::size_t point = 100; point < 200; ++point) {
      map.graph.remove_landmark(map.landmark_of[point]);
      map.landmark_of[point] = -1;
    }
  }
  /// The input that tracking hands over for a frame at `mapping_pose(id)`.
  KeyframeInput input(std::int64_t id, std::int64_t reference, ObserveOptions how = {}) {
    const Observed observed = observe(id, mapping_pose(static_cast<int>(id)), how);
    KeyframeInput input;
    input.frame = observed.frame;
    input.reference = reference;
    const SE3 step = mapping_pose(static_cast<int>(id)) * mapping_pose(static_cast<int>(reference)).inverse();
    input.camera_from_reference = SE3(step.rotation(), scale() * step.translation());
    input.points = map.tracked(observed);
    return input;
  }
  /// Scale of the map: map units per meter, from the first two keyframes.
  double scale() const {
    return map.graph.camera_from_world(1).translation().norm() / mapping_pose(1).translation().norm();
  }
  /// Number of landmarks at the ground-truth point of all their features.
  std::size_t true_landmarks(double relative_error, double scale = 1.0) const {
    std::size_t count = 0;
    for (const std::int64_t id : map.graph.landmark_ids()) {
      const MapLandmark& landmark = map.graph.landmark(id);
      bool right = !landmark.observations.empty();
      for (const LandmarkObservation& o : landmark.observations) {
        const Eigen::Vector3d ground_truth =
            scale * world.points[seen[static_cast<std::size_t>(o.keyframe)][o.feature]];
        right &= (landmark.position - ground_truth).norm() < relative_error * ground_truth.norm();
      }
      count += right;
    }
    return count;
  }

  OrbSlamOptions options;
  PointWorld world;
  ExactMap map;
  LocalMapping mapping;
  std::vector<std::vector<std::uint32_t>> seen;  ///< By keyframe: the point of each feature.
};

inline OrbSlamOptions without_keyframe_culling() {
  OrbSlamOptions options;
  options.cull_seen_share = 1.0;
  return options;
}

}  // namespace rastro::testing
