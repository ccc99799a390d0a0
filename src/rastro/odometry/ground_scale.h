// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"

namespace rastro {

/// Metres from a camera at a known height above a flat road, METHODS 2.4. The road between two frames moves by the
/// homography of its plane (Hartley and Zisserman 2004, section 13.1), whose only unknowns, once the camera's motion is
/// known but for scale, is the height in the unit of that motion: the road runs along the way the camera goes. The
/// height is found by comparing grey levels directly, over all frames together: single frames see too little texture on
/// a road.
class GroundScale {
 public:
  GroundScale(const Camera& camera, double camera_height_m) : camera_(camera), camera_height_m_(camera_height_m) {}

  /// Frames in order, with poses of one scale.
  void add(GreyView image, const SE3& world_from_camera);

  struct Found {
    double metres_per_unit = 1.0;
    double pitch_rad = 0.0;       ///< How far the camera looks below the horizon.
    double relative_sigma = 0.0;  ///< Of the scale, from the halves of the frames.
    int frames = 0;               ///< Pairs that spoke.
  };
  /// nullopt when too few pairs of frames showed a road.
  std::optional<Found> find() const;

 private:
  /// Mean difference of grey levels for every height tried.
  using Costs = std::vector<float>;
  void choose_samples(GreyView image);
  void keep_textured(GreyView image);
  std::optional<Costs> compare(GreyView image, const SE3& current_from_last);
  /// Costs of pairs of frames together, each brought to at most 1: constant memory however long the run.
  struct Sums {
    std::vector<double> total;
    std::vector<int> votes;
    int frames = 0;

    void add(const Costs& costs);
    void add(const Sums& other);
  };
  static std::optional<double> best_of(const Sums& sums);

  float difference(GreyView image, const std::vector<Eigen::Vector3d>& turned, const Eigen::Vector3d& moved) const;

  /// A pixel of the last image where the road should be.
  struct Sample {
    Eigen::Vector2d ray;
    int x, y;
    float grey;
  };
  Camera camera_;
  double camera_height_m_;
  std::vector<Sample> samples_;   ///< Everywhere on the road.
  std::vector<Sample> textured_;  ///< Those worth comparing with, of the last image.
  int width_ = 0, height_ = 0;
  std::optional<SE3> last_pose_;
  Eigen::Vector3d direction_ = Eigen::Vector3d::Zero();  ///< Of the last steps.
  double pitch_rad_ = 0.0;
  Sums even_, odd_;  ///< Every second pair, so that two halves can be held against each other.
};

}  // namespace rastro
