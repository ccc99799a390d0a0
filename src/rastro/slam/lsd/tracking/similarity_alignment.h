// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "rastro/math/sim3.h"
#include "rastro/slam/lsd/tracking/image_alignment.h"

namespace rastro {

struct SimilarityAlignmentOptions {
  int coarsest_level = 4;                             ///< Or the last one that both sides have.
  int finest_level = 1;                               ///< Loop closures need no more, and the finest one costs most.
  int iterations = 30;                                ///< On each level.
  double epsilon_px = 0.01, coarse_epsilon_px = 0.1;  ///< As of ImageAlignmentOptions.
  PhotometricNoise noise;
  int min_points = 100;           ///< On the finest level, and as many with an inverse depth in both keyframes.
  double min_overlap = 0.3;       ///< Share of the points of a.
  double min_inlier_share = 0.5;  ///< Share of the points that fit.
  bool fix_scale = false;         ///< Keep the guess's: both sides are metric.
};

/// Keyframe b of align_similarity().
struct SimilarityTarget {
  const Pyramid& image;                       ///< Made by alignment_pyramid().
  const std::vector<InverseDepthMap>& depth;  ///< AlignmentReference::depth() or inverse_depth_pyramid().
};

struct SimilarityAlignment {
  Sim3 b_from_a;                    ///< Each side in the unit of its own inverse depth.
  double gain = 1.0, offset = 0.0;  ///< As of ImageAlignment.
  /// Of d in true b_from_a = b_from_a * exp(d): (translation, rotation, log of the scale), with what ImageAlignment
  /// says about its covariance. 0 if a direction is undetermined.
  Matrix7d information = Matrix7d::Zero();
  double rms = 0.0;           ///< Robust root mean square of all residuals, standard deviations.
  double overlap = 0.0;       ///< Share of the points of a that project into b.
  double inlier_share = 0.0;  ///< Share of the points that are compared and fit within three standard deviations.
  int points = 0;             ///< Compared by intensity.
  int depth_points = 0;       ///< Of these, compared by inverse depth too.
  bool converged = false;     ///< On the finest level.
  AlignmentFailure failure = AlignmentFailure::too_few_points;

  bool ok() const { return failure == AlignmentFailure::none; }
};

/// Motion and scale between two keyframes that both have inverse depth: minimizes photometric and inverse depth
/// residuals, each divided by its standard deviation, with a Huber norm of both together (Engel et al. 2014, section
/// 3.5, equations 13 to 18). The inverse depth in b is that of the nearest pixel. Without SIMD; takes some ten
/// milliseconds at 640 x 480.
SimilarityAlignment align_similarity(const AlignmentReference& a, const SimilarityTarget& b, const Sim3& b_from_a_guess,
                                     const SimilarityAlignmentOptions& options = {});

/// Squared Mahalanobis distance between two independent alignments of the same keyframes: chi-squared with 7 degrees of
/// freedom if both are right (Engel et al. 2014, section 3.5, reciprocal tracking check). nullopt if one has no
/// information.
std::optional<double> reciprocal_error(const SimilarityAlignment& b_from_a, const SimilarityAlignment& a_from_b);

}  // namespace rastro
