// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "rastro/evaluate/length_candidates.h"

namespace rastro {

/// One view's candidates for the features of an object.
struct LengthFinding {
  std::int64_t keyframe = 0;
  bool has_depth = false;
  std::vector<std::vector<LengthCandidate>> candidates;  ///< Per feature.
};

/// A feature and the views that agree on it.
struct FoundFeature {
  std::vector<std::pair<std::size_t, LengthCandidate>> observations;  ///< With the index of the finding.
  Eigen::Vector3d point = Eigen::Vector3d::Zero(), direction = Eigen::Vector3d::Zero();  ///< Means.
  double height_m = 0.0;                 ///< Of the face above the rough one, without depth.
  double wrong_position_variance = 0.0;  ///< For the risk of a wrong edge.
  double rivalry = 0.0;                  ///< Relative votes of the best competing offset, 0 .. 1.
};

/// How far the points of a feature may be from the given ones.
struct LengthPrior {
  static constexpr double spot_sigma_share = 0.4;  ///< Standard deviation of a rough point, of the radius.
  double radius_m = 0.06;
  double height_sigma_m = 0.0;  ///< Of the face above the rough one; 0: depth tells its height.
};

/// The feature numbered `which` where most views have a candidate: near the rough point rather than far from it.
FoundFeature agreed_feature(const std::vector<LengthFinding>& findings, std::size_t which, const LengthFeature& feature,
                            const LengthPrior& prior);

/// Intersection of the two edges of a corner, or their closest points, in each view that has both.
FoundFeature crossing_of(const FoundFeature& one, const FoundFeature& other);

}  // namespace rastro
