// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "rastro/evaluate/length_feature.h"
#include "rastro/evaluate/length_views.h"
#include "rastro/evaluate/map_lengths.h"

namespace rastro {

/// One view's candidate for the feature; world frame.
struct LengthCandidate {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< Of the edge, or the normal of the face.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double score = 0.0;
  int points = 0;
  double support = 0.0;
  double shared_m = 0.0;  ///< Standard deviation of the error common to all views.
  /// Derivative of the point by the height of the face, where that is not measured.
  Eigen::Vector3d lever = Eigen::Vector3d::Zero();
  std::array<Eigen::Vector2d, 2> pixels{};
};

/// The edges or the face within `radius_m` of the feature's rough point that one view shows. `by_depth`: on the face
/// that the view's depth measures there, else on the one through the given points.
std::vector<LengthCandidate> length_candidates(const LengthView& view, const LengthFeature& feature, double radius_m,
                                               const MapLengthOptions& options, bool by_depth);

}  // namespace rastro
