// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/optimize/pose_graph.h"
#include "rastro/slam/rgbd/options.h"

namespace rastro {

/// Where a keyframe stands.
struct KeyframePose {
  SE3 world_from_camera;  ///< In the frame of its submap.
  int submap = 0;         ///< Merged submaps share the smallest number and one frame.
};

/// Keyframes, their poses and ties, and what is asked of them: whom to compare with, how far apart they are, where they
/// stand when all ties are heard. Those below `frozen` belong to a map made before, and stay.
class KeyframeGraph {
 public:
  KeyframeGraph(const RgbdSlamOptions& options, std::int64_t frozen);

  /// Its id must be size(); `covariance` is of d in truth = pose * exp(d).
  void add(std::shared_ptr<const ImageFeatures> keyframe, const KeyframePose& pose, const Matrix6d& covariance);
  void add_edge(const Constraint& edge);
  /// Without what it is matched by, to save memory.
  void forget_features(std::int64_t id);

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

  /// Whom to compare keyframe `id`, the newest, with: METHODS 8. In a fixed order, none twice.
  std::vector<std::int64_t> candidates(std::int64_t id, Random& random) const;
  /// Ties from one to the other, counted along the shortest way; `most` where it is longer, or there is none.
  int steps_between(std::int64_t from, std::int64_t to, int most) const;
  /// Brings the submap of the larger number to the frame of the other, as `edge` between them says.
  void join(const Constraint& edge);
  /// Of the last keyframes alone, or of all.
  PoseGraphResult optimize(bool all);
  /// A bound on what is known of a keyframe against its submap's first: the surest of its neighbours and the edge to
  /// it. More ties only make it surer.
  void settle_covariance(std::int64_t id);

 private:
  std::vector<std::int64_t> neighbourhood(std::int64_t id, int steps) const;

  RgbdSlamOptions options_;
  std::int64_t frozen_;
  std::vector<std::shared_ptr<const ImageFeatures>> keyframes_;
  std::vector<SE3> poses_;
  std::vector<int> submaps_;
  std::vector<Matrix6d> covariances_;
  std::vector<Constraint> edges_;
  std::vector<std::vector<std::size_t>> edges_of_;  ///< Into edges_.
};

}  // namespace rastro
