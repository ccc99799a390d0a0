// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/backend/rgbd/options.h"
#include "rastro/base/random.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/optimize/pose_graph.h"

namespace rastro {

/// The pose of a keyframe.
struct KeyframePose {
  SE3 world_from_camera;  ///< In the frame of its submap.
  int submap = 0;         ///< Merged submaps share the smallest number and one frame.
};

/// Motion between two keyframes by odometry.
struct TrackedMotion {
  SE3 from_from_to;
  Matrix6d covariance = Matrix6d::Zero();  ///< Of d in true motion = from_from_to * exp(d).
};

/// What is left of a keyframe's features to save memory: none of them.
std::shared_ptr<const ImageFeatures> without_features(const ImageFeatures& keyframe);

/// Keyframes with their poses and constraints: which keyframes to compare, their distance in the graph, and their
/// optimized poses. Keyframes below `frozen` belong to a given map and stay fixed.
class KeyframeGraph {
 public:
  KeyframeGraph(const RgbdSlamOptions& options, std::int64_t frozen);

  /// Its id must be size(); `covariance` is of d in true pose = pose * exp(d).
  void add(std::shared_ptr<const ImageFeatures> keyframe, const KeyframePose& pose, const Matrix6d& covariance);
  void add_edge(const Constraint& edge);
  /// Drops the features that it is matched by, to save memory.
  void forget_features(std::int64_t id);
  /// Gives them back, to the keyframe of that id.
  void restore_features(std::shared_ptr<const ImageFeatures> keyframe);

  /// Among the keyframes before the last graph_window that still have features: the one with edges to the most others
  /// that still have theirs, at least `others`; the oldest of equals. nullopt: none.
  std::optional<std::int64_t> most_redundant(int others) const;

  std::int64_t size() const { return static_cast<std::int64_t>(keyframes_.size()); }
  std::int64_t frozen() const { return frozen_; }
  const ImageFeatures& keyframe(std::int64_t id) const { return *keyframes_[static_cast<std::size_t>(id)]; }
  const std::shared_ptr<const ImageFeatures>& shared_keyframe(std::int64_t id) const {
    return keyframes_[static_cast<std::size_t>(id)];
  }
  const SE3& pose(std::int64_t id) const { return poses_[static_cast<std::size_t>(id)]; }
  int submap(std::int64_t id) const { return submaps_[static_cast<std::size_t>(id)]; }
  const Matrix6d& covariance(std::int64_t id) const { return covariances_[static_cast<std::size_t>(id)]; }
  const std::vector<Constraint>& edges() const { return edges_; }
  std::vector<KeyframePose> keyframe_poses() const;

  /// Which keyframes to compare with keyframe `id`, the newest: METHODS 8. In a fixed order, without duplicates.
  std::vector<std::int64_t> candidates(std::int64_t id, Random& random) const;
  /// Number of edges on the shortest path between the two; `most` if it is longer, or if there is none.
  int steps_between(std::int64_t from, std::int64_t to, int most) const;
  /// Length of the path through the keyframes of a submap from one to a later one, meters. A rotation counts like a
  /// step of a meter per radian, since tracking drifts in it too.
  double path_between(std::int64_t from, std::int64_t to) const;
  /// Lengths of the shortest paths over the constraints from a keyframe to every one, counted in the same way; infinity
  /// where there is none. Every accepted loop closure makes paths shorter: what contradicts it stands out.
  std::vector<double> graph_paths_from(std::int64_t from) const;
  /// What tracking alone says of the motion from one keyframe to a later one; nullopt after a loss between them, or
  /// with more than `most_steps` keyframes between.
  std::optional<TrackedMotion> tracked_motion(std::int64_t from, std::int64_t to, int most_steps) const;
  /// Merges two submaps: transforms the one with the larger number into the frame of the other, by the `edge` between
  /// them.
  void merge(const Constraint& edge);
  /// Optimizes the last keyframes only, or all.
  PoseGraphResult optimize(bool all);
  /// All keyframes, as long as it helps.
  PoseGraphResult optimize_until_converged();
  /// Sets an upper bound of a keyframe's covariance relative to the first of its submap: that of the best neighbor plus
  /// the edge to it. Further edges would only reduce it.
  void settle_covariance(std::int64_t id);

 private:
  std::vector<std::int64_t> neighborhood(std::int64_t id, int steps) const;

  RgbdSlamOptions options_;
  std::int64_t frozen_;
  std::vector<std::shared_ptr<const ImageFeatures>> keyframes_;
  std::vector<SE3> poses_;
  std::vector<int> submaps_;
  std::vector<Matrix6d> covariances_;
  std::vector<Constraint> edges_;
  std::vector<double> lengths_;                     ///< Of edges_: graph_paths_from().
  std::vector<std::vector<std::size_t>> edges_of_;  ///< Into edges_.
};

}  // namespace rastro
