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
  double sigma_m = 0.0;   ///< Of what the keyframe itself measured; that of its pose is not in it.
  double shared_m = 0.0;  ///< Standard deviation of what may be off alike in all keyframes.
  /// How the value changes with the height of the face it was found on, where only that is unknown (no depth).
  double lever = 0.0;
};

/// One end of a length. At most one sighting a keyframe.
struct LengthSightings {
  std::vector<LengthSighting> all;
  /// What is known of the height of the face, for those with a lever: its mean and standard deviation, metres.
  double height_m = 0.0, height_sigma_m = 0.0;
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
/// of the poses. Heights of faces without depth are found along with it: keyframes that look at them from different
/// sides tell. Outliers are left out. nullopt where one of the features is not seen.
std::optional<CombinedLength> combine_lengths(LengthSightings a, LengthSightings b);

}  // namespace rastro
