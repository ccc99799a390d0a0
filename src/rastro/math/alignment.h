// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "rastro/math/sim3.h"

namespace rastro {

enum class AlignmentKind {
  yaw,         ///< Rotation about the z axis and translation: for systems with observable gravity.
  rigid,       ///< SE3.
  similarity,  ///< Sim3: for systems without metric scale.
};

struct Alignment {
  Sim3 target_from_source;  ///< Scale 1 for yaw and rigid.
  double rmse = 0.0;        ///< Root mean squared distance of the aligned points, meters.
  bool unique = false;      ///< False if the points do not determine the rotation (collinear, or fewer than three).
};

/// The transform that aligns `source` with `target` (pairs by index) with the least sum of squared distances, in closed
/// form: Umeyama 1991, "Least-squares estimation of transformation parameters between two point patterns". nullopt
/// without pairs, with values that are not finite, or for a similarity if the source (or the target) is a single point.
std::optional<Alignment> align_points(std::span<const Eigen::Vector3d> target, std::span<const Eigen::Vector3d> source,
                                      AlignmentKind kind);

}  // namespace rastro
