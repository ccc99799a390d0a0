// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"

namespace rastro {

/// Metric scale from a camera at a known height above a flat road, METHODS 2.4. Between two frames the road moves by
/// the homography of its plane (Hartley and Zisserman 2004, section 13.1). Once the camera's motion is known up to
/// scale, the homography's only unknown is the camera height in the unit of that motion: the road is parallel to the
/// direction of travel. The height is found by direct comparison of intensities over all frames together, because a
/// single frame sees too little texture on a road.
class GroundScale {
 public:
  GroundScale(const Camera& camera, double camera_height_m) : camera_(camera), camera_height_m_(camera_height_m) {}

  /// Frames in order, with poses of one common scale.
  void add(GrayView image, const SE3& world_from_camera);

  struct Found {
    double meters_per_unit = 1.0;
    double pitch_rad = 0.0;       ///< Camera's downward pitch from the horizon.
    double relative_sigma = 0.0;  ///< Of the scale, from two halves of the frames.
    int frames = 0;               ///< Frame pairs that contributed.
  };
  /// nullopt if too few pairs of frames show a road.
  std::optional<Found> find() const;

 private:
  /// Mean intensity difference for every height hypothesis.
  using Costs = std::vector<float>;
  void choose_samples(GrayView image);
  void keep_textured(GrayView image);
  std::optional<Costs> compare(GrayView image, const SE3& current_from_last);
  /// Sums the costs of frame pairs, each scaled to at most 1. Memory is constant for any length of run.
  struct Sums {
    std::vector<double> total;
    std::vector<int> votes;
    int frames = 0;

    void add(const Costs& costs);
    void add(const Sums& other);
  };
  static std::optional<double> best_of(const Sums& sums);

  float difference(GrayView image, const std::vector<Eigen::Vector3d>& rotated, const Eigen::Vector3d& moved) const;

  /// A pixel of the previous image on the assumed road.
  struct Sample {
    Eigen::Vector2d ray;
    int x, y;
    float gray;
  };
  Camera camera_;
  double camera_height_m_;
  std::vector<Sample> samples_;   ///< All over the road.
  std::vector<Sample> textured_;  ///< Those with texture, in the previous image.
  int width_ = 0, height_ = 0;
  std::optional<SE3> last_pose_;                         ///< Of the image compared with.
  double usual_step_ = 0.0;                              ///< Running mean of the steps compared; 0: none yet.
  Eigen::Vector3d direction_ = Eigen::Vector3d::Zero();  ///< Of the last motions.
  double pitch_rad_ = 0.0;
  Sums even_, odd_;  ///< Every second pair, so that two halves can be compared.
};

}  // namespace rastro
