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

/// A feature seen in two views, normalised (x/z, y/z).
struct TwoViewPair {
  Eigen::Vector2d first = Eigen::Vector2d::Zero(), second = Eigen::Vector2d::Zero();
  double first_sigma_px = 1.0, second_sigma_px = 1.0;  ///< Standard deviations, pixels: the scale of the level.
};

struct TwoViewOptions {
  double focal_px = 500.0;                 ///< Turns normalised lengths into pixels.
  double homography_chi2 = 5.991;          ///< Squared sigmas up to which a pair fits: two degrees of freedom...
  double fundamental_chi2 = 3.841;         ///< ... and one.
  double homography_share = 0.45;          ///< S_H / (S_H + S_F) above which the scene is taken for a plane.
  int max_iterations = 200;                ///< Samples, of either model.
  int min_points = 50;                     ///< To be triangulated, or it does not start.
  double min_model_share = 0.5;            ///< Of all pairs, that the model taken must explain.
  double near_plane_share = 0.40;          ///< S_H / (S_H + S_F) above which a plane may be what is seen ...
  double near_plane_model_share = 0.8;     ///< ... unless this share of all pairs fits the fundamental matrix.
  double max_rotation_score = 0.9;         ///< Share of its score that a turn on the spot may reach.
  double min_inlier_share = 0.8;           ///< Of the model's inliers, that the motion taken must see in front.
  double max_runner_up = 0.7;              ///< Share of the best motion's points that the second best may have.
  double min_parallax_deg = 1.0;           ///< Median over the model's inliers.
  double least_point_parallax_deg = 0.36;  ///< Of a point; with less it is taken to be at infinity.
  std::uint64_t seed = 1;
};

enum class TwoViewStatus : std::uint8_t {
  found,
  too_few_pairs,
  no_model,       ///< Neither model explains enough.
  little_motion,  ///< No motion, or a rotation alone: the directions to the points hardly differ.
  ambiguous,      ///< Two motions explain it about as well.
  too_few_points,
};

const char* name_of(TwoViewStatus status);  ///< "found", "too few pairs", ...

/// What two views say of motion and scene.
struct TwoViewFit {
  TwoViewStatus status = TwoViewStatus::too_few_pairs;
  std::string detail;   ///< What it waits for, with its numbers: "median parallax 0.3 deg, need 1.0"; empty when found.
  bool planar = false;  ///< The homography was taken.
  double homography_score = 0.0, fundamental_score = 0.0;  ///< S_H and S_F.
  double share = 0.0;                                      ///< S_H / (S_H + S_F).
  int inliers = 0;                                         ///< Of the model taken.
  double median_parallax_deg = 0.0;  ///< Of its inliers: how far directions differ once the turn is taken out.
  SE3 second_from_first;             ///< Translation of length 1. Of meaning when found.
  /// One a pair, in the first camera's frame; nullopt: not seen in front of both at its pixels with parallax.
  std::vector<std::optional<Eigen::Vector3d>> points;
  int triangulated = 0;
};

/// Motion and points from two views, METHODS 6: a homography and a fundamental matrix at once, the better one's motions
/// all tried (Faugeras and Lustman 1988; Hartley and Zisserman 2004, section 9.6), and none taken unless one is clearly
/// right (Mur-Artal et al. 2015, section IV). The same seed gives the same bits.
TwoViewFit find_two_view_motion(std::span<const TwoViewPair> pairs, const TwoViewOptions& options);

}  // namespace rastro
