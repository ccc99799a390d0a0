// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rastro/math/se3.h"
#include "rastro/multiview/point_pairs.h"

namespace rastro {

/// Motion between two views, up to the scale of its translation.
struct EssentialFit {
  Eigen::Matrix3d essential = Eigen::Matrix3d::Zero();  ///< b' E a = 0, E = [t]x R.
  SE3 second_from_first;                                ///< Translation of length 1, as from recover_pose().
  std::vector<std::uint8_t> is_inlier;                  ///< One per pair.
  int inliers = 0;
  int iterations = 0;  ///< Samples drawn.
  int in_front = 0;    ///< Inliers in front of both cameras.
  /// Median over the inliers: angle between the directions to a point after removing the rotation. Near 0 the
  /// translation is meaningless: the camera was at rest or only rotated.
  double median_parallax_deg = 0.0;
};

/// Up to ten essential matrices from the five pairs at `indices`. Nister 2004, "An efficient solution to the five-point
/// relative pose problem"; the roots of its polynomial by real_roots().
std::vector<Eigen::Matrix3d> essential_from_five(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b,
                                                 const std::uint32_t* indices);

/// E by RANSAC over five pairs. Errors are Sampson distances in pixels, and every new best model is refined over its
/// inliers on the five-dimensional manifold of motions. `a` and `b`: the same points in the first and second view,
/// normalized. nullopt for fewer than five pairs or if no sample gives a model with five inliers. Points on one plane
/// have two solutions, of which it returns either (Longuet-Higgins 1986). The same seed gives the same bits.
std::optional<EssentialFit> estimate_essential(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b,
                                               const CalibratedRansacOptions& options);

struct RecoveredPose {
  SE3 second_from_first;  ///< Translation of length 1.
  int in_front = 0;       ///< Pairs in front of both cameras.
  int runner_up = 0;      ///< The same of the second-best of the four: if near in_front, the choice is ambiguous.
  double median_parallax_deg = 0.0;
};

/// The one of E's four motions with most points in front of both cameras; the first of equals. Uses the pairs with
/// is_inlier (all if it is empty). nullopt if no pair is in front. Hartley and Zisserman 2004, section 9.6.
std::optional<RecoveredPose> recover_pose(const Eigen::Matrix3d& essential, std::span<const Eigen::Vector2d> a,
                                          std::span<const Eigen::Vector2d> b, std::span<const std::uint8_t> is_inlier);

/// E of a motion: [t]x R with t normalized to length 1.
Eigen::Matrix3d essential_of(const SE3& second_from_first);

/// The motion with the least sum of squared Sampson distances over the pairs with is_inlier (all if it is empty):
/// Gauss-Newton over rotation and direction of translation from `start`. nullopt without a solution.
std::optional<SE3> refine_relative_pose(const SE3& start, std::span<const Eigen::Vector2d> a,
                                        std::span<const Eigen::Vector2d> b, std::span<const std::uint8_t> is_inlier,
                                        int iterations = 10);

}  // namespace rastro
