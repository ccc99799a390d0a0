// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

namespace rastro {

struct GroundHeightOptions {
  double pitch_rad = 0.0;           ///< How far the camera looks below the horizon.
  double min_depression_deg = 3.0;  ///< Points nearer to the horizon tell too little of their height.
  double kernel = 0.03;             ///< Standard deviation of the vote, as a share of the height.
  double max_tilt_deg = 3.0;        ///< Of the fitted plane from the expected one; 0 leaves the normal as expected.
  int min_support = 12;             ///< Fewer points on the plane are none.
};

struct GroundHeight {
  double height = 0.0;                                ///< Of the camera above the ground, in the unit of the points.
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< Downwards in the camera frame, length 1.
  int support = 0;                                    ///< Points within three kernel widths.
  double share = 0.0;                                 ///< Of the points below the horizon.
};

/// Height of the camera above the ground from points in its frame (x right, y down, z forward), of any scale: the
/// densest height of the points below the horizon, by a Gaussian kernel as wide as a share of the height, then a plane
/// through them. After the scale estimation of Geiger, Ziegler and Stiller 2011, "StereoScan". nullopt when no height
/// has support enough.
std::optional<GroundHeight> estimate_ground_height(std::span<const Eigen::Vector3d> points_in_camera,
                                                   const GroundHeightOptions& options);

}  // namespace rastro
