// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "rastro/feature/orb.h"
#include "rastro/place/vocabulary.h"
#include "rastro/slam/lsd/constraint_search.h"
#include "rastro/slam/lsd/current_keyframe.h"
#include "rastro/slam/lsd/lsd_frame.h"
#include "rastro/slam/lsd/pose_uncertainty.h"
#include "rastro/slam/lsd/semi_dense_graph.h"
#include "rastro/slam/slam.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// The map: the newest keyframe, whose depths frames improve, and the graph of all keyframes.
class LsdMapping {
 public:
  /// Options, sensor and frames outlive this.
  LsdMapping(const LsdOptions& options, const LsdSensor& sensor, const LsdFrameMaker& frames,
             const SlamContext& context);

  /// The first keyframe of a new submap.
  void begin_map(CurrentKeyframe first, SlamUpdate& update);
  /// A tracked frame improves the depths of the current keyframe.
  void refine(const LsdFrame& frame, const ImageAlignment& tracked) { current_->refine(frame, tracked); }
  /// Engel et al. 2013, section 2.3: the distance in mean inverse depths; and what is out of view.
  bool needs_keyframe(const ImageAlignment& tracked) const;
  /// The tracked frame becomes the keyframe; returns its unit in that of the one before. `depth_from_color`: motion of
  /// the camera from the instant of the image to that of a depth camera's depth.
  double change_keyframe(const LsdFrame& frame, const ImageAlignment& tracked, const SE3& depth_from_color,
                         SlamUpdate& update);
  /// The camera was found again in an earlier keyframe, which goes on.
  void return_to(CurrentKeyframe earlier, SlamUpdate& update);
  void add_frame(const PlacedFrame& frame) { graph_.add_frame(frame); }

  bool has_keyframe() const { return current_.has_value(); }
  const CurrentKeyframe& current() const { return *current_; }  ///< The newest keyframe, if there is one.
  const SemiDenseGraph& graph() const { return graph_; }
  CurrentKeyframe restored_keyframe(std::int64_t id) const;
  /// world_from_camera of a frame relative to the current keyframe.
  SE3 pose_of(const SE3& camera_from_keyframe) const;
  /// None in a submap apart from the first: where it lies is unknown.
  std::optional<Matrix6d> covariance_of(const ImageAlignment& tracked, const SE3& world_from_camera) const;
  /// Says what is not known yet: where a submap lies, and random depths at first.
  void doubt(SlamUpdate& update) const;
  BagOfWords words_of(const LsdFrame& frame) { return words_of(frame.image.view(), frame.mask.view()); }
  MapMemory memory() const;

 private:
  void finish_keyframe(SlamUpdate& update);
  void connect(std::int64_t id, const BagOfWords& words, SlamUpdate& update);
  void stay_within_budget(SlamUpdate& update);
  BagOfWords words_of(GrayView image, GrayView mask);

  const LsdOptions& options_;
  const LsdSensor& sensor_;
  const LsdFrameMaker& frames_;
  TaskPool* pool_;
  SemiDenseGraph graph_;
  PoseUncertainty uncertainty_;
  ConstraintSearch constraints_;
  OrbExtractor features_;
  std::optional<CurrentKeyframe> current_;
  std::size_t budget_bytes_;    ///< 0: none.
  std::int64_t forgotten_ = 0;  ///< Keyframes without depths.
};

}  // namespace rastro
