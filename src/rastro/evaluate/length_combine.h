// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace rastro {

/// Where one keyframe sees a feature, along the direction that is measured.
struct LengthSighting {
  std::int64_t keyframe = 0;
  double value_m = 0.0;
  double sigma_m = 0.0;  ///< Of what the keyframe itself measured; that of its pose is not in it.
};

struct CombinedLength {
  double length_m = 0.0;  ///< b - a
  double sigma_m = 0.0;
  int seen_a = 0, seen_b = 0, together = 0;  ///< Keyframes that agree; those that see both.
  double pose_sigma_m = 0.0;  ///< Scatter of the keyframes' places that what they measured does not explain.
  double scatter_m = 0.0;     ///< Of the lengths of keyframes that see both, else of the values of each feature.
};

/// Generalised least squares over all keyframes: what a keyframe's pose is off moves both features alike, so that
/// keyframes that see both tell the length without their poses, while those that see one of them count with the scatter
/// of the poses. Outliers are left out. nullopt where one of the features is not seen. At most one sighting a keyframe.
std::optional<CombinedLength> combine_lengths(std::vector<LengthSighting> a, std::vector<LengthSighting> b);

}  // namespace rastro
