// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rastro/math/se3.h"

namespace rastro {

/// A feature observed in two views, normalized (x/z, y/z).
struct TwoViewPair {
  Eigen::Vector2d first = Eigen::Vector2d::Zero(), second = Eigen::Vector2d::Zero();
  double first_sigma_px = 1.0, second_sigma_px = 1.0;  ///< Standard deviations, pixels: the scale of the pyramid level.
};

struct TwoViewOptions {
  double focal_px = 500.0;              ///< Converts normalized lengths to pixels.
  double homography_chi2 = 5.991;       ///< Inlier bound of the squared standardised error: two degrees of freedom...
  double fundamental_chi2 = 3.841;      ///< ... and one.
  double homography_share = 0.45;       ///< S_H / (S_H + S_F) above which the homography is selected.
  int min_iterations = 200;             ///< Samples for the fundamental matrix, at least ...
  int max_iterations = 400;             ///< ... and at most, of either model.
  int min_points = 50;                  ///< Minimum number of triangulated points.
  double min_model_share = 0.5;         ///< Minimum share of inliers of the selected model.
  double near_plane_share = 0.40;       ///< S_H / (S_H + S_F) above which the scene may be a plane ...
  double near_plane_model_share = 0.8;  ///< ... unless this share of all pairs fits the fundamental matrix.
  double max_rotation_score = 0.9;      ///< Maximum share of its score that a pure rotation may reach ...
  double max_competing_score = 0.95;    ///< ... and that another motion may ...
  double competing_angle_deg = 15.0;    ///< ... whose direction differs by this much.
  double min_inlier_share = 0.8;        ///< Minimum share of the model's inliers in front of both views.
  double max_runner_up = 0.7;           ///< Maximum share of the best motion's points for the second best.
  double min_parallax_deg = 1.0;        ///< Median over the model's inliers.
  double least_point_parallax_deg = 0.36;  ///< Of a point; with less it counts as at infinity.
  std::uint64_t seed = 1;
};

enum class TwoViewStatus : std::uint8_t {
  found,
  too_few_pairs,
  no_model,       ///< Neither model has enough inliers.
  little_motion,  ///< No motion, or a rotation alone: the directions to the points hardly differ.
  ambiguous,      ///< Two motions are about equally good.
  too_few_points,
};

const char* name_of(TwoViewStatus status);  ///< "found", "too few pairs", ...

/// Result of two-view initialization.
struct TwoViewFit {
  TwoViewStatus status = TwoViewStatus::too_few_pairs;
  std::string detail;   ///< Reason of failure, with its numbers: "median parallax 0.3 deg, need 1.0"; empty when found.
  bool planar = false;  ///< The homography was selected.
  double homography_score = 0.0, fundamental_score = 0.0;  ///< S_H and S_F.
  double share = 0.0;                                      ///< S_H / (S_H + S_F).
  int inliers = 0;                                         ///< Of the selected model.
  /// Median over its inliers: angle between the directions after removing the rotation.
  double median_parallax_deg = 0.0;
  SE3 second_from_first;  ///< Translation of length 1. Valid when found.
  /// One per pair, in the first camera's frame; nullopt: not in front of both views with small error and enough
  /// parallax.
  std::vector<std::optional<Eigen::Vector3d>> points;
  int triangulated = 0;
};

/// Two-view initialization, METHODS 6: motion and points from a homography and a fundamental matrix in parallel. Tries
/// all motions of the better model (Faugeras and Lustman 1988; Hartley and Zisserman 2004, section 9.6) and accepts one
/// only if it is clearly the best (Mur-Artal et al. 2015, section IV). The same seed gives the same bits.
TwoViewFit find_two_view_motion(std::span<const TwoViewPair> pairs, const TwoViewOptions& options);

}  // namespace rastro
