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

/// Motion between two views up to the length of its translation.
struct EssentialFit {
  Eigen::Matrix3d essential = Eigen::Matrix3d::Zero();  ///< b' E a = 0, E = [t]x R.
  SE3 second_from_first;                                ///< Translation of length 1, as of recover_pose().
  std::vector<std::uint8_t> is_inlier;                  ///< One a pair.
  int inliers = 0;
  int iterations = 0;  ///< Samples drawn.
  int in_front = 0;    ///< Inliers in front of both cameras.
  /// Of the inliers: how far the directions to a point differ once the rotation is taken out. Near 0 the translation
  /// means nothing: the camera stood still or only turned.
  double median_parallax_deg = 0.0;
};

/// Up to ten essential matrices of five pairs, read at `indices`. Nister 2004, "An efficient solution to the five-point
/// relative pose problem"; the roots of its polynomial by real_roots().
std::vector<Eigen::Matrix3d> essential_from_five(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b,
                                                 const std::uint32_t* indices);

/// E by RANSAC over five pairs; errors are Sampson distances in pixels, and every new best model is refined over its
/// inliers on the five-dimensional manifold of motions. `a` and `b`: the same points in the first and second view,
/// normalised. nullopt for fewer than five pairs or when no sample gives a model with five inliers. Points
/// of one plane are explained by two motions, of which it takes either (Longuet-Higgins 1986). The same seed gives the
/// same bits.
std::optional<EssentialFit> estimate_essential(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b,
                                               const CalibratedRansacOptions& options);

struct RecoveredPose {
  SE3 second_from_first;  ///< Translation of length 1.
  int in_front = 0;       ///< Pairs in front of both cameras.
  int runner_up = 0;      ///< As many of the second-best of the four: near in_front the choice was a guess.
  double median_parallax_deg = 0.0;
};

/// The one of E's four motions with most points in front of both cameras; the first of equals. Only pairs with
/// is_inlier count (all when it is empty). nullopt when no pair is in front. Hartley and Zisserman 2004, section 9.6.
std::optional<RecoveredPose> recover_pose(const Eigen::Matrix3d& essential, std::span<const Eigen::Vector2d> a,
                                          std::span<const Eigen::Vector2d> b, std::span<const std::uint8_t> is_inlier);

/// E of a motion: [t]x R with t brought to length 1.
Eigen::Matrix3d essential_of(const SE3& second_from_first);

/// The motion with the least sum of squared Sampson distances over the pairs with is_inlier (all when it is empty):
/// Gauss-Newton over rotation and direction of translation from `start`. nullopt when it has no solution.
std::optional<SE3> refine_relative_pose(const SE3& start, std::span<const Eigen::Vector2d> a,
                                        std::span<const Eigen::Vector2d> b, std::span<const std::uint8_t> is_inlier,
                                        int iterations = 10);

}  // namespace rastro
