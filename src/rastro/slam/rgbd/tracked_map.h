// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/map/graph/map.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/slam/rgbd/mapper.h"

namespace rastro {

/// The map as the tracker knows it: what the mapper has given back so far, keyframes that it is still busy with, and
/// where every frame stands relative to its keyframe.
class TrackedMap {
 public:
  /// `base`: what all snapshots share (camera, session), or the map given, which never changes.
  TrackedMap(Map base, std::shared_ptr<const PictureStore> images, bool given);

  std::int64_t keyframe_count() const { return static_cast<std::int64_t>(poses_.size() + pending_.size()); }
  /// Known to the mapper, with features.
  const std::vector<std::shared_ptr<const ImageFeatures>>& keyframes() const { return keyframes_; }
  SE3 pose(std::int64_t keyframe) const;
  int submap(std::int64_t keyframe) const;
  const Matrix6d& covariance(std::int64_t keyframe) const { return covariances_[static_cast<std::size_t>(keyframe)]; }
  std::int64_t revision() const { return revision_; }
  int submap_count() const { return submaps_; }
  int new_submap() { return submaps_++; }

  /// A keyframe that the mapper was asked for.
  void add_pending(const KeyframePose& pose, const Matrix6d& covariance);
  /// Everything pending from `first` on is taken elsewhere.
  void move_pending(std::int64_t first, const SE3& new_world_from_world);
  void apply(MapRevision revision);
  void add_frame(TimeNs stamp, std::int64_t keyframe, const SE3& keyframe_from_camera);
  /// The submap with most frames is called 0 from here on. False where it is already.
  bool make_largest_first();

  /// Of the frames of submap 0.
  Trajectory trajectory() const;
  std::shared_ptr<const Map> snapshot() const;

 private:
  struct PlacedFrame {
    TimeNs stamp = 0;
    std::int64_t keyframe = 0;
    SE3 keyframe_from_camera;
  };

  Map base_;
  std::shared_ptr<const PictureStore> images_;
  bool given_;
  std::vector<std::shared_ptr<const ImageFeatures>> keyframes_;
  std::vector<KeyframePose> poses_;
  std::deque<KeyframePose> pending_;
  std::vector<Matrix6d> covariances_;
  std::vector<Constraint> edges_;
  std::vector<PlacedFrame> frames_;
  int submaps_ = 0;
  std::int64_t revision_ = 0;
};

}  // namespace rastro
