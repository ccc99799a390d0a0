// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/slam/orb/local_mapping/direct_poses.h"
#include "rastro/slam/orb/map/map_graph.h"
#include "rastro/slam/orb/options.h"
#include "rastro/slam/orb/tracking/frame_tracker.h"

namespace rastro {

/// Frames since the last keyframe in which a landmark should have been visible, and those in which it was found.
struct LandmarkCounts {
  int visible = 0, found = 0;
};

/// A frame that becomes a keyframe, as tracking hands it over.
struct KeyframeInput {
  std::shared_ptr<const FeatureFrame> frame;
  std::int64_t reference = -1;  ///< A keyframe of the map...
  SE3 camera_from_reference;
  double reference_unit = 1.0;  ///< ... and its unit in the view.
  std::vector<TrackedPoint> points;
  std::map<std::int64_t, LandmarkCounts> counts{};  ///< By landmark.
  std::shared_ptr<const DirectView> view{};         ///< Null: features alone.
};

/// What bundle adjustment did to a keyframe.
struct AdjustedKeyframe {
  std::int64_t id = -1;
  SE3 world_from_camera_before, world_from_camera;
};

/// Local mapping of a new keyframe, METHODS 6 (Mur-Artal et al. 2015, section VI).
class LocalMapping {
 public:
  /// The graph is the caller's and outlives this. `stop` (may be null): once true, adjustments end early because the
  /// run is ending. `direct`: null: features alone.
  LocalMapping(const OrbSlamOptions& options, MapGraph& graph, TaskPool* pool, const std::atomic<bool>* stop = nullptr,
               const DirectAlignment* direct = nullptr);

  /// Initializes a submap with its first two keyframes and their points in the first camera's frame (one per pair of
  /// features, in order). False, and nothing is kept, if fewer than init_points are left after bundle
  /// adjustment.
  bool initialize(const std::shared_ptr<const FeatureFrame>& first, const std::shared_ptr<const FeatureFrame>& second,
                  const SE3& second_from_first, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs,
                  const std::vector<std::optional<Eigen::Vector3d>>& points, int submap);
  /// Initializes a submap with its first keyframe, from depth.
  void initialize(const std::shared_ptr<const FeatureFrame>& frame, int submap);
  /// Processes a keyframe from insertion to culling; without loop closing. Returns what frames can be aligned with, or
  /// null.
  std::shared_ptr<const DirectView> process(const KeyframeInput& input);
  /// Those free in the bundle adjustment of the last process().
  const std::vector<AdjustedKeyframe>& adjusted() const { return adjusted_; }
  /// As process() keeps and returns it, of the keyframe that a submap was initialized with.
  std::shared_ptr<const DirectView> add_view(std::int64_t keyframe, const DirectView* view) {
    return direct_.add(keyframe, view);
  }
  std::size_t view_bytes() const { return direct_.bytes(); }
  /// Adjusts all keyframes and landmarks of a submap; the root stays fixed.
  void adjust_all(int submap, int iterations);

 private:
  void insert_keyframe(const KeyframeInput& input);
  void add_observations(std::int64_t keyframe, const std::vector<TrackedPoint>& points);
  void cull_landmarks(std::int64_t keyframe);
  void create_landmarks(std::int64_t keyframe);
  void add_depth_landmarks(std::int64_t keyframe);
  void triangulate_landmarks(std::int64_t keyframe);
  void triangulate_with(std::int64_t keyframe, std::int64_t neighbor);
  void fuse_landmarks(std::int64_t keyframe);
  std::vector<std::int64_t> fusion_targets(std::int64_t keyframe) const;
  void fuse_into(std::int64_t keyframe, const std::vector<std::int64_t>& landmarks);
  void adjust_locally(std::int64_t keyframe);
  std::vector<std::int64_t> fixed_observers(const std::vector<std::int64_t>& free) const;
  std::vector<AdjustedKeyframe> adjust(const std::vector<std::int64_t>& free, const std::vector<std::int64_t>& fixed,
                                       int iterations);
  void cull_keyframes(std::int64_t keyframe);
  bool is_redundant(const MapKeyframe& keyframe) const;
  double median_depth(const MapKeyframe& keyframe) const;

  OrbSlamOptions options_;
  MapGraph& graph_;
  TaskPool* pool_;
  const std::atomic<bool>* stop_;
  DirectPoses direct_;
  std::vector<std::int64_t> recent_;  ///< Recently created landmarks, still subject to culling.
  std::vector<AdjustedKeyframe> adjusted_;
};

}  // namespace rastro
