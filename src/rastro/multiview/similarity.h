// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rastro/math/sim3.h"

namespace rastro {

/// A point that two cameras know, each in its own frame and unit, and where each sees it, normalised (x/z, y/z).
struct SimilarityPair {
  Eigen::Vector3d first_point = Eigen::Vector3d::Zero(), second_point = Eigen::Vector3d::Zero();
  Eigen::Vector2d first_ray = Eigen::Vector2d::Zero(), second_ray = Eigen::Vector2d::Zero();
  double first_sigma = 1.0 / 500.0, second_sigma = 1.0 / 500.0;  ///< Standard deviations of the rays.
};

struct SimilarityOptions {
  bool fix_scale = false;  ///< Both units are the same: only a rigid motion is looked for.
  double chi2 = 9.21;      ///< Squared sigmas up to which a pair is an inlier, in either camera: 99 %.
  /// Of the logarithm of a point's depths in the first camera, one by its own point and one by the other's. All that
  /// tells the scale where both cameras stand at the same place. Not used where the scale is fixed.
  double depth_sigma = 0.2;
  double confidence = 0.99;  ///< That one sample is free of outliers.
  int max_iterations = 300;
  int refine_iterations = 10;
  std::uint64_t seed = 1;
};

struct SimilarityFit {
  Sim3 first_from_second;
  std::vector<std::uint8_t> is_inlier;  ///< One a pair.
  int inliers = 0;
  int iterations = 0;  ///< Samples drawn.
};

/// Similarity between the frames of two cameras by RANSAC over three pairs in closed form (Horn 1987), with
/// reprojection errors in both cameras, refined over its inliers. nullopt for fewer than three pairs or inliers. The
/// same seed gives the same bits.
std::optional<SimilarityFit> estimate_similarity(std::span<const SimilarityPair> pairs,
                                                 const SimilarityOptions& options);

/// The refinement alone: the least sum of squared reprojection errors in both cameras, and of depths, with Huber's
/// kernel, then inliers judged anew and once more. nullopt when nothing is left.
std::optional<SimilarityFit> refine_similarity(std::span<const SimilarityPair> pairs, const Sim3& first_from_second,
                                               const SimilarityOptions& options);

}  // namespace rastro
