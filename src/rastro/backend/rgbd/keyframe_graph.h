// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "rastro/backend/rgbd/graph_paths.h"
#include "rastro/backend/rgbd/options.h"
#include "rastro/backend/rgbd/variance_factor.h"
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

/// What optimizations and merges changed, and what is new: nothing else has to be told to anyone.
struct GraphChanges {
  struct EdgeWeight {
    std::size_t edge = 0;  ///< Counted in the order in which edges were added.
    double weight = 1.0;
  };
  std::int64_t first_pose = 0;
  std::vector<KeyframePose> poses;                             ///< Of the keyframes from `first_pose` on.
  std::vector<EdgeWeight> weights;                             ///< Of the edges at these.
  std::vector<std::pair<std::int64_t, Matrix6d>> covariances;  ///< Of the keyframes of submaps that were merged.
};

/// What is left of a keyframe's features to save memory: none of them.
std::shared_ptr<const ImageFeatures> without_features(const ImageFeatures& keyframe);

/// How much of the last optimization of a run is affordable.
struct FinalOptimization {
  bool gradual = true;  ///< Switches are introduced in stages, of which each costs a round. Else what loop closures
                        ///< decided stands.
  int rounds = 10;      ///< At most.
};
/// All of it for maps of up to about 16 000 constraints; a larger one is bounded to as much work, one round at least.
/// `gradual` counts for loop closures as well, where a new loop that is far off has the stages in any case.
FinalOptimization final_optimization(std::size_t edges, int iterations);

/// A constraint whose position has a larger standard deviation does not connect its keyframes; what closes a loop over
/// it needs proof as if there were no path.
constexpr double uncertain_edge_m = 1.5;

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
  int submap_count() const { return static_cast<int>(first_of_submap_.size()); }
  /// Since the last call.
  GraphChanges take_changes();

  /// Which keyframes to compare with keyframe `id`, the newest: METHODS 8. In a fixed order, without duplicates.
  std::vector<std::int64_t> candidates(std::int64_t id, Random& random) const;
  /// Number of edges on the shortest path between the two; `most` if it is longer, or if there is none. Without those
  /// that say too little, see uncertain_edge_m.
  int steps_between(std::int64_t from, std::int64_t to, int most) const;
  /// Length of the path through the keyframes of a submap from one to a later one, meters. A rotation counts like a
  /// step of a meter per radian, since tracking drifts in it too.
  double path_between(std::int64_t from, std::int64_t to) const;
  /// Lengths of the shortest paths over the constraints, counted in the same way. Every accepted loop closure makes
  /// paths shorter: what contradicts it stands out. To be asked before the graph changes.
  GraphPaths graph_paths_from(std::int64_t from) const;
  /// What tracking alone says of the motion from one keyframe to a later one; nullopt after a loss between them, or
  /// with more than `most_steps` keyframes between.
  std::optional<TrackedMotion> tracked_motion(std::int64_t from, std::int64_t to, int most_steps) const;
  /// Merges two submaps: transforms the one with the larger number into the frame of the other, by the `edge` between
  /// them.
  void merge(const Constraint& edge);
  /// Optimizes the last keyframes only, in a time that does not depend on the number of the others, or all.
  PoseGraphResult optimize(bool all);
  /// All keyframes, as long as it helps.
  PoseGraphResult optimize_until_converged();
  /// Sets an upper bound of a keyframe's covariance relative to the first of its submap: that of the best neighbor plus
  /// the edge to it. Further edges would only reduce it.
  void settle_covariance(std::int64_t id);
  /// Of the covariances of constraints and tracked motions, as residuals show it.
  double variance_factor() const { return noise_.value(); }
  /// From all constraints at the poses as they are, as those of a given map.
  void learn_noise();

 private:
  /// A part of the graph, with ids that are indices into its own vectors.
  struct Part {
    std::vector<std::int64_t> keyframes;
    std::vector<SE3> poses;
    std::vector<std::uint8_t> fixed;
    std::vector<std::size_t> edge_numbers;
    std::vector<Constraint> edges;
  };

  std::vector<std::int64_t> neighborhood(std::int64_t id, int steps) const;
  Matrix6d covariance_over(const Constraint& edge, std::int64_t id) const;
  Matrix6d moved_covariance(const Matrix6d& covariance, std::int64_t from, std::int64_t to) const;
  void add_covariance_of_merge(const Constraint& edge, std::int64_t joint);
  std::vector<std::size_t> edges_from(std::int64_t first) const;
  bool is_anchor(std::int64_t id) const;
  bool a_new_loop_is_far_off() const;
  Part part_from(std::int64_t first_free) const;
  void learn_noise(const Part& part);
  PoseGraphResult optimize(bool all, const PoseGraphOptions& options);

  RgbdSlamOptions options_;
  std::int64_t frozen_;
  std::vector<std::shared_ptr<const ImageFeatures>> keyframes_;
  std::vector<SE3> poses_;
  std::vector<int> submaps_;
  std::vector<Matrix6d> covariances_;
  std::vector<Constraint> edges_;
  std::vector<double> lengths_;                     ///< Of edges_: graph_paths_from().
  std::vector<std::uint8_t> uncertain_;             ///< Of edges_: they connect nothing.
  std::vector<std::vector<std::size_t>> edges_of_;  ///< Into edges_.
  std::map<int, std::int64_t> first_of_submap_;     ///< The first keyframe of each anchors it.
  std::size_t decided_edges_ = 0;                   ///< Those that were there when all keyframes were optimized last.
  VarianceFactor noise_;
  std::int64_t first_changed_ = 0;  ///< Of the poses, since take_changes().
  std::set<std::int64_t> merged_;   ///< Whose covariances a merge changed since then.
};

}  // namespace rastro
