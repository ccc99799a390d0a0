// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/current_keyframe.h"

namespace rastro {

ImageAlignment CurrentKeyframe::track(const Pyramid& image, const SE3& image_from_keyframe) const {
  return track(image, image_from_keyframe, options_->levels - 1);
}

ImageAlignment CurrentKeyframe::track(const Pyramid& image, const SE3& image_from_keyframe, int coarsest_level) const {
  ImageAlignmentOptions options;
  options.coarsest_level = coarsest_level;
  options.min_overlap = options_->min_overlap;
  options.noise.intensity_sigma = options_->intensity_sigma;
  return align_image(*reference_, image, image_from_keyframe, options, pool_);
}

bool CurrentKeyframe::is_left_by(const ImageAlignment& tracked) const {
  const double distance = tracked.image_from_reference.inverse().translation().norm();
  // Depths are shown once two frames saw them: a keyframe that ends before that has fewer than the one before it.
  const bool is_new = frames_ < options_->keyframe_frames;
  const double overlap =
      is_new ? 0.5 * (options_->keyframe_overlap + options_->min_overlap) : options_->keyframe_overlap;
  return tracked.rms < options_->keyframe_residual &&
         (distance * mean_inverse_depth_ > options_->keyframe_distance || tracked.overlap < overlap);
}

bool CurrentKeyframe::tells_scale(const ImageAlignment& tracked) const {
  return tracked.motion_error() <= options_->max_motion_error;
}

bool CurrentKeyframe::is_met_by(const ImageAlignment& tracked) const {
  const double distance = tracked.image_from_reference.inverse().translation().norm();
  return tracked.rms < options_->keyframe_residual &&
         distance * mean_inverse_depth_ < options_->return_share * options_->keyframe_distance &&
         1.0 - tracked.overlap < options_->return_share * (1.0 - options_->keyframe_overlap);
}

}  // namespace rastro
