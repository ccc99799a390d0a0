// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rastro/backend/rgbd/surface_check.h"
#include "rastro/math/se3.h"

namespace rastro {

/// One feature observed in two views. A depth of 0 means not measured; with neither, only the direction counts.
struct PointMatch {
  Eigen::Vector2d ray_a = Eigen::Vector2d::Zero(), ray_b = Eigen::Vector2d::Zero();  ///< Normalized (x/z, y/z).
  double depth_a = 0.0, depth_b = 0.0;                                               ///< Meters.
  double sigma_a = 1.0, sigma_b = 1.0;                                               ///< Of the pixel position.

  bool has_depth() const { return depth_a > 0.0 || depth_b > 0.0; }
};

struct PointMatchOptions {
  DepthNoise noise;
  double focal_px = 500.0;
  double max_sigmas = 3.0;
  int iterations = 300;
  int min_inliers = 10;
  int min_depth_inliers = 6;  ///< Of these, with a depth.
  double min_depth_m = 0.3;   ///< Of a feature whose depth was not measured.
  std::uint64_t seed = 1;
};

struct MatchedViews {
  SE3 a_from_b;
  /// Inverse covariance of d in true pose = a_from_b * exp(d), from the noise model; inflated where the residuals are
  /// larger.
  Matrix6d information = Matrix6d::Identity();
  int inliers = 0;
};

/// The relative pose that most matches agree with. RANSAC over three matches each: 3D to 3D where all have both depths
/// (closed form), else 3D to 2D (P3P); scored and refined over pixels and depths, weighted by their sigmas. `guess`,
/// where given, is tried first. nullopt with fewer than min_inliers inliers or min_depth_inliers with a depth, or when
/// they do not determine the pose.
/// The same seed gives the same bits.
std::optional<MatchedViews> estimate_views(std::span<const PointMatch> matches, const PointMatchOptions& options,
                                           const std::optional<SE3>& guess = std::nullopt);

}  // namespace rastro
