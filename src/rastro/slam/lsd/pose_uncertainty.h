// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>

#include "rastro/math/se3.h"
#include "rastro/slam/lsd/tracking/image_alignment.h"

namespace rastro {

/// Covariances of poses in the world's axes, as of SlamUpdate::covariance: that of an alignment, and those of all
/// alignments by which its keyframe was placed. In the world's unit; of one camera without the drift of the scale.
class PoseUncertainty {
 public:
  /// Of the first keyframe of a submap: it defines the world.
  void set_known(std::int64_t keyframe, const Eigen::Vector3d& position);
  /// `unit`: of the keyframe, in that of the world. `mean_inverse_depth`: of the keyframe, in its unit. Zero for
  /// keyframes never set.
  Matrix6d of_frame(std::int64_t keyframe, double unit, double mean_inverse_depth, const SE3& world_from_camera,
                    const ImageAlignment& alignment) const;
  bool knows(std::int64_t keyframe) const { return keyframes_.contains(keyframe); }
  /// A frame becomes a keyframe.
  void set(std::int64_t keyframe, const Eigen::Vector3d& position, const Matrix6d& covariance);

 private:
  struct Placed {
    Eigen::Vector3d position;
    Matrix6d covariance;
  };
  std::map<std::int64_t, Placed> keyframes_;
};

}  // namespace rastro
