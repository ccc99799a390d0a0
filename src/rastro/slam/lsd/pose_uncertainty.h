// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/backend/map_uncertainty.h"
#include "rastro/math/se3.h"
#include "rastro/slam/lsd/tracking/image_alignment.h"

namespace rastro {

/// A frame aligned to a keyframe.
struct AlignedFrame {
  std::int64_t keyframe = 0;
  double unit = 1.0;                ///< Of the keyframe, in that of the world.
  double mean_inverse_depth = 0.0;  ///< Of the keyframe, in its unit.
  SE3 world_from_camera;
  ImageAlignment alignment;
};

/// Covariances of poses in the world's axes and unit, as of SlamUpdate::covariance: that of an alignment, and those of
/// all alignments by which its keyframe was placed.
class PoseUncertainty {
 public:
  /// `scale_drift`: standard deviation of the drift of the scale from a keyframe to the next, as share; 0 where the
  /// scale is measured.
  explicit PoseUncertainty(double scale_drift) : scale_drift_(scale_drift) {}
  /// Of the first keyframe of a submap: it defines the world.
  void set_known(std::int64_t keyframe, const Eigen::Vector3d& position);
  /// The frame has become that keyframe. One that is known keeps what is known of it.
  void add(std::int64_t keyframe, const Eigen::Vector3d& position, const AlignedFrame& frame);
  /// A keyframe that was never added is certain.
  Matrix6d of_frame(const AlignedFrame& frame) const;

 private:
  double scale_drift_;
  MapUncertainty keyframes_;
};

}  // namespace rastro
