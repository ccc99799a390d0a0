// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "rastro/base/task_pool.h"
#include "rastro/slam/lsd/options.h"
#include "rastro/slam/lsd/tracking/image_alignment.h"

namespace rastro {

/// What frames are tracked on: a keyframe as its depths were at one instant. Never changes; copies are cheap.
class CurrentKeyframe {
 public:
  /// `options` and `pool` outlive this.
  CurrentKeyframe(const LsdOptions& options, TaskPool* pool, std::int64_t id, std::shared_ptr<const Pyramid> pyramid,
                  std::shared_ptr<const AlignmentReference> reference, double mean_inverse_depth, int frames)
      : options_(&options),
        pool_(pool),
        id_(id),
        pyramid_(std::move(pyramid)),
        reference_(std::move(reference)),
        mean_inverse_depth_(mean_inverse_depth),
        frames_(frames) {}

  ImageAlignment track(const Pyramid& image, const SE3& image_from_keyframe) const;
  /// From this level on, which follows only motions of a pixel of it or so.
  ImageAlignment track(const Pyramid& image, const SE3& image_from_keyframe, int coarsest_level) const;
  /// Engel et al. 2013, section 2.3: whether a frame is too far away, in mean inverse depths, or sees too much else.
  bool is_left_by(const ImageAlignment& tracked) const;
  /// Whether the motion to a frame is known well enough for a map that goes on from it: the scale of what comes into
  /// view there, with one camera, follows from that motion.
  bool tells_scale(const ImageAlignment& tracked) const;
  /// Whether a frame is near enough that this keyframe is used again instead of a new one.
  bool is_met_by(const ImageAlignment& tracked) const;

  std::int64_t id() const { return id_; }
  const Pyramid& pyramid() const { return *pyramid_; }
  const AlignmentReference& reference() const { return *reference_; }
  double mean_inverse_depth() const { return mean_inverse_depth_; }
  double attenuation() const { return static_cast<double>(reference_->level(0).attenuation); }
  int pixels() const { return reference_->level(0).count; }  ///< With a depth.

 private:
  const LsdOptions* options_;
  TaskPool* pool_;
  std::int64_t id_;
  std::shared_ptr<const Pyramid> pyramid_;
  std::shared_ptr<const AlignmentReference> reference_;
  double mean_inverse_depth_;
  int frames_;  ///< That improved its depths.
};

}  // namespace rastro
