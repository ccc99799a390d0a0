// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>

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
  double attenuation = 0.0;  ///< Of the keyframe, as AlignmentPoints::attenuation.
  double scale_error = 0.0;  ///< Of the keyframe's scale, as a share, beyond what scales drift.
};

/// How errors of the depths that frames are aligned by reach their poses.
struct DepthErrorModel {
  double alike = 1.0;        ///< Pixels whose errors are alike: an alignment averages over that many fewer.
  double scale_drift = 0.0;  ///< Standard deviation of the scale's drift from a keyframe to the next, as share.
  double scale = 0.0;        ///< Standard deviation of all scales together, as share.
  double attenuation = 0.0;  ///< Of the depths' errors: how much of it motions may be too short, standard deviation.
  double attenuation_of_step = 0.0;  ///< The same, of each step to a keyframe for itself.
};
/// Depths that follow from motion err like it, all along a surface.
constexpr double depths_alike_of_one_camera = 30.0;
inline DepthErrorModel errors_of_one_camera(double scale_drift) {
  return {depths_alike_of_one_camera, scale_drift, 0.0, 0.0, 0.0};
}
inline DepthErrorModel errors_of_depth_camera() { return {2.0, 0.0, 0.003, 0.0, 0.0}; }
/// On walks motion is too short by what the errors of the depths say, about, by 0.2 to 0.6 %, and for some
/// twenty keyframes in a row by half more or less than that: as if each step erred by sqrt(20) times as much for
/// itself.
inline DepthErrorModel errors_of_pair() { return {2.0, 0.0, 0.001, 1.2, 2.0}; }

/// About as much of a view is new as went out of it.
inline double share_of_new(const ImageAlignment& tracked) { return 1.0 - tracked.overlap; }
/// Of one camera's scale: of what is new, it is known as well as the motion that its depths follow from.
inline double scale_variance_of_new(double share_of_new, double motion_error) {
  return share_of_new * share_of_new * std::min(1.0, depths_alike_of_one_camera * motion_error * motion_error);
}

/// Covariances of poses in the world's axes and unit, as of SlamUpdate::covariance: that of an alignment, and those of
/// all alignments by which its keyframe was placed.
class PoseUncertainty {
 public:
  explicit PoseUncertainty(const DepthErrorModel& errors) : errors_(errors) {}
  /// Of the first keyframe of all: it defines the world.
  void set_known(std::int64_t keyframe, const Eigen::Vector3d& position);
  /// The frame has become that keyframe. One that is known keeps what is known of it.
  void add(std::int64_t keyframe, const Eigen::Vector3d& position, const AlignedFrame& frame);
  /// A keyframe of a submap that a constraint joined to `earlier` with `covariance`, in the world's axes and unit, and
  /// `scale_variance`.
  void join(std::int64_t keyframe, const Eigen::Vector3d& position, std::int64_t earlier, const Matrix6d& covariance,
            double scale_variance);
  bool knows(std::int64_t keyframe) const { return keyframes_.contains(keyframe); }
  /// A keyframe that was never added counts as certain.
  Matrix6d of_frame(const AlignedFrame& frame) const;

 private:
  Eigen::Vector3d shortening_of(const AlignedFrame& frame) const;

  /// By what a pose is off if the motions that led to it are too short by their attenuations, to the same share each.
  struct Shortening {
    Eigen::Vector3d position, sum;
  };
  DepthErrorModel errors_;
  MapUncertainty keyframes_;
  std::map<std::int64_t, Shortening> shortening_;
};

}  // namespace rastro
