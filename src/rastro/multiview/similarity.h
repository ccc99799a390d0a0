// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rastro/math/sim3.h"

namespace rastro {

/// A point known to two cameras, each in its own frame and unit, with its observation in each, normalized (x/z, y/z).
struct SimilarityPair {
  Eigen::Vector3d first_point = Eigen::Vector3d::Zero(), second_point = Eigen::Vector3d::Zero();
  Eigen::Vector2d first_ray = Eigen::Vector2d::Zero(), second_ray = Eigen::Vector2d::Zero();
  double first_sigma = 1.0 / 500.0, second_sigma = 1.0 / 500.0;  ///< Standard deviations of the rays.
};

struct SimilarityOptions {
  bool fix_scale = false;  ///< Both units are the same: estimates a rigid motion.
  double chi2 = 9.21;      ///< Inlier bound of the squared standardised error in either camera: 99 %.
  /// Standard deviation of the logarithm of a point's depth in the first camera, by its own point and by the other's.
  /// Determines the scale if both cameras are at the same position. Not used with a fixed scale.
  double depth_sigma = 0.2;
  double confidence = 0.99;  ///< Probability that one sample is free of outliers.
  int max_iterations = 300;
  int refine_iterations = 10;
  std::uint64_t seed = 1;
};

struct SimilarityFit {
  Sim3 first_from_second;
  std::vector<std::uint8_t> is_inlier;  ///< One per pair.
  int inliers = 0;
  int iterations = 0;  ///< Samples drawn.
};

/// Similarity between the frames of two cameras by RANSAC over three pairs in closed form (Horn 1987), with
/// reprojection errors in both cameras, refined over its inliers. nullopt for fewer than three pairs or inliers. The
/// same seed gives the same bits.
std::optional<SimilarityFit> estimate_similarity(std::span<const SimilarityPair> pairs,
                                                 const SimilarityOptions& options);

/// The refinement alone: least squares of the reprojection errors in both cameras, and of depths, with Huber's kernel;
/// then selects the inliers again and refines once more. nullopt if no inliers are left.
std::optional<SimilarityFit> refine_similarity(std::span<const SimilarityPair> pairs, const Sim3& first_from_second,
                                               const SimilarityOptions& options);

}  // namespace rastro
