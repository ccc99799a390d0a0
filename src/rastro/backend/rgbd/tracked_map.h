// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "rastro/backend/rgbd/mapper.h"
#include "rastro/map/graph/map.h"
#include "rastro/map/images/image_layer.h"

namespace rastro {

/// The map as the tracker knows it: the mapper's results so far, the keyframes still pending there, and every frame's
/// pose relative to its keyframe.
class TrackedMap {
 public:
  /// `base`: what all snapshots share (camera, session), or the given map, which never changes. With `signatures`,
  /// these are in the map instead of the features in memory.
  TrackedMap(Map base, std::shared_ptr<const ImageStore> images, bool given,
             std::shared_ptr<const SignatureStore> signatures = nullptr);

  std::int64_t keyframe_count() const { return static_cast<std::int64_t>(poses_.size() + pending_.size()); }
  /// Returned by the mapper, with features.
  const std::vector<std::shared_ptr<const ImageFeatures>>& keyframes() const { return keyframes_; }
  SE3 pose(std::int64_t keyframe) const;
  int submap(std::int64_t keyframe) const;
  const Matrix6d& covariance(std::int64_t keyframe) const { return covariances_[static_cast<std::size_t>(keyframe)]; }
  /// Keyframes of `submap` whose pose is closest to `pose` in position and viewing direction, the nearest first.
  /// `bare`: also those without features in memory.
  std::vector<std::int64_t> nearest(const SE3& pose, int submap, const RgbdSlamOptions& options,
                                    bool bare = false) const;
  /// Whether an edge between the two has been handed over.
  bool are_connected(std::int64_t a, std::int64_t b) const;
  std::int64_t revision() const { return revision_; }
  std::size_t frame_count() const { return frames_.size(); }
  int submap_count() const { return submaps_; }
  int new_submap() { return submaps_++; }

  /// A keyframe requested from the mapper, seen from keyframe `from` with that covariance; -1: the first of a submap.
  void add_pending(const KeyframePose& pose, std::int64_t from, const Matrix6d& covariance);
  /// Transforms all pending keyframes from `first` on, which belong to `submap` from now on. They become as certain as
  /// what they are seen from.
  void move_pending(std::int64_t first, const SE3& new_world_from_world, int submap);
  void apply(MapRevision revision);
  void add_frame(TimeNs stamp, std::int64_t keyframe, const SE3& keyframe_from_camera);
  /// Renumbers the submap with most frames to 0. False if it already is.
  bool make_largest_first();

  /// Submap 0, or the one with most frames of this session where none of them is connected to submap 0.
  int trajectory_submap() const;
  /// Of the frames of this session in trajectory_submap().
  Trajectory trajectory() const;
  std::shared_ptr<const Map> snapshot() const;
  /// Of the keyframes that revisions told of, where places are recognized.
  const std::vector<PlaceBelief>& places() const { return places_; }

 private:
  struct PendingKeyframe {
    KeyframePose pose;
    std::int64_t from = -1;
    Matrix6d covariance = Matrix6d::Zero();  ///< Seen from there.
  };
  struct PosedFrame {
    TimeNs stamp = 0;
    std::int64_t keyframe = 0;
    SE3 keyframe_from_camera;
  };

  void continue_base();
  Matrix6d covariance_of(const PendingKeyframe& keyframe) const;
  void add_edge(const Constraint& edge);
  std::vector<std::int64_t> frames_per_submap() const;

  Map base_;
  std::shared_ptr<const ImageStore> images_;
  std::shared_ptr<const SignatureStore> signatures_;
  bool given_;  ///< The map is only localized in: poses are in its frame, or unknown.
  std::vector<std::shared_ptr<const ImageFeatures>> keyframes_;
  std::vector<double> weights_;  ///< Of keyframes_.
  std::vector<KeyframePose> poses_;
  std::deque<PendingKeyframe> pending_;
  std::vector<Matrix6d> covariances_;
  std::vector<Constraint> edges_;
  std::set<std::pair<std::int64_t, std::int64_t>> connected_;  ///< By edges_, the smaller id first.
  std::vector<PosedFrame> frames_;
  std::vector<PlaceBelief> places_;
  int submaps_ = 0;
  std::int64_t revision_ = 0;
};

}  // namespace rastro
